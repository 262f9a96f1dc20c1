#!/bin/bash
# The files for SLURM in configs/cluster: what they run, with stand-ins for srun and scontrol. A
# training that the time limit stops is queued again, and goes on.
#   test_cluster.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"
cluster=$ROOT/configs/cluster

for file in "$cluster"/*.sbatch; do
    check syntax -- bash -n "$file"
    check options alone on lines of SBATCH -- test \
        "$(grep '^#SBATCH' "$file" | grep -cvE '^#SBATCH --[a-z-]+(=[^ ]+)?$')" -eq 0
    check a signal before the limit -- grep -q '^#SBATCH --signal=TERM@60$' "$file"
done

# srun leaves its own options out, and stops a training that is told to; scontrol keeps its words.
mkdir bin
cat >bin/srun <<'END_OF_SRUN'
#!/bin/bash
echo "srun $*" >>calls.txt
while [ "${1#--}" != "$1" ]; do shift; done
[ -e stop ] || exec "$@"
"$@" &
for _ in $(seq 6000); do
    [ "$(cat runs/*/history.csv 2>/dev/null | wc -l)" -ge 2 ] && break
    sleep 0.01
done
kill -TERM $!
wait $!
END_OF_SRUN
printf '#!/bin/sh\necho "scontrol $*" >>calls.txt\n' >bin/scontrol
chmod +x bin/*
PATH=$PWD/bin:$PATH
export SLURM_JOB_ID=7 SLURM_ARRAY_JOB_ID=5 SLURM_ARRAY_TASK_ID=3 SLURM_CPUS_PER_TASK=1
sed 's/hidden: .*/hidden: [4]/; s/steps: 5000$/steps: 20/; s/steps: 500$/steps: 40000/' "$elastica" >small.yaml
printf '%s\n' 'output: {every: 10}' >>small.yaml

# twice FILE FOLDER REQUEUED SRUN: stopped and queued again, then resumed to the end.
twice() {
    rm -rf runs calls.txt
    touch stop
    run 143 bash "$cluster/$1" small.yaml
    same calls.txt <(printf 'srun %s --threads 1 --quiet\nscontrol requeue %s\n' "$4" "$3")
    check a checkpoint -- test -s "$2/checkpoint.h5"
    rm stop calls.txt
    run 0 bash "$cluster/$1" small.yaml
    same calls.txt <(printf 'srun %s --resume --threads 1 --quiet\n' "$4")
}
twice train.sbatch runs/small 7 \
    '--mpi=pmix --kill-on-bad-exit=1 cpinn-train small.yaml --out runs/small'
twice sweep.sbatch runs/small-seed-3 5_3 \
    '--ntasks=1 cpinn-train small.yaml --out runs/small-seed-3 --set training.seed=3'
run 1 bash "$cluster/train.sbatch"
said stderr.txt 'CONFIG.yaml$'
finish
