#!/bin/bash
# Training and evaluation by several processes: the bits of one, also when it goes on with another
# number of them; processes that die; programs that do not share their work. Without mpirun there is nothing to do.
#   test_ranks.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"
command -v mpirun >/dev/null || exit 77
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 # in containers
over=()
mpirun --version | grep -q 'Open MPI' && over=(--oversubscribe)

# by N COMMAND...
by() {
    local n=$1
    shift
    timeout 120 mpirun "${over[@]}" -n "$n" "$@"
}

# answers FOLDER...: same history but for seconds, same answers.
answers() {
    local first=$1 folder
    for folder in "$@"; do
        run 0 cpinn-eval "$folder" --grid 11x7 --out "$folder.csv"
        without_seconds "$folder/history.csv" >"$folder.history"
        same "$folder.csv" "$first.csv"
        same "$folder.history" "$first.history"
    done
}

# ---- first-order and quasi-Newton methods, points and weights that follow training --------------

deep=(cpinn-train "$ROOT/configs/cantilever_deep.yaml" --threads 1 --quiet --set output.every=5
    --set 'network.hidden=[12, 12]' --set losses.interior.points=300
    --set losses.held_out_points=64)
stages() {
    local method stages=
    for method in $(optimizers); do
        [ "$method" != gauss_newton ] &&
            stages="$stages{optimizer: $method, steps: $1}, "
    done
    echo "training.stages=[$stages{optimizer: gauss_newton, steps: 2, $2}]"
}
causal=("${deep[@]}" --set "$(stages 20 "linear_algebra: matrix_free, scaling: identity")" --set losses.causal.slices=3
    --set losses.causal.update_every=7 --set losses.interior.sampler=uniform
    --set losses.interior.resample_every=9)
run 3 "${causal[@]}" --out causal
for n in 1 2 3; do
    run 3 by "$n" "${causal[@]}" --out "causal_$n"
done
answers causal causal_1 causal_2 causal_3

moving=("${deep[@]}" --set "$(stages 20 "scaling: diagonal")" --set losses.balance=gradient_norm
    --set losses.interior.adaptive.kind=rad --set losses.interior.adaptive.every=8)
run 3 "${moving[@]}" --out moving
run 3 by 3 "${moving[@]}" --out moving_3
answers moving moving_3

# ---- memory ---------------------------------------------------------------------------------------

# memory N: MiB of the largest of N processes that share 4 million points of 16 bytes.
memory() {
    rm -f peak.*
    run 3 by "$1" python3 -c 'import os, resource, subprocess, sys
status = subprocess.call(sys.argv[1:])
with open(f"peak.{os.getpid()}", "w") as file:
    print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss // 1024, file=file)
sys.exit(status)' cpinn-train "$ROOT/configs/cantilever_deep.yaml" --threads 1 --quiet --set reference=null \
        --set losses.interior.points=4194304 --set losses.held_out_points=64 --set 'network.hidden=[4]' \
        --set 'training.stages=[{optimizer: adam, steps: 1}]' --out "memory_$1"
    cat peak.* | sort -n | tail -1
}
alone=$(memory 1) shared=$(memory 4)
# 48 of 64 MiB of points, less some 10 of MPI's own for each process beside it.
check "memory: $alone MiB alone, $shared MiB of one of four" -- test "$((alone - shared))" -ge 30

# ---- a process that dies, and others that go on ---------------------------------------------------

long=("${deep[@]}" --set "$(stages 400 "scaling: diagonal")" --set checkpoint.every=20
    --set losses.interior.resample_every=150)
run 3 "${long[@]}" --out long
by 2 "${long[@]}" --out killed >stdout.txt 2>stderr.txt </dev/null &
pid=$!
while [ "$(cat killed/history.csv 2>/dev/null | wc -l)" -lt 30 ] && kill -0 "$pid"; do
    sleep 0.02
done
children=$(pgrep -f -- "^[^ ]*cpinn-train .*--out killed" | sort -n)
check two processes train -- test "$(wc -w <<<"$children")" -eq 2
kill -9 "${children##*$'\n'}"
wait "$pid" && failed "a run with a dead process ended well"
pid=
run 0 cpinn-eval killed --grid 11x7 --out killed.csv
run 3 by 3 "${long[@]}" --out killed --resume
answers long killed

# A signal to any of them ends all after a step; the clock is that of the first.
by 2 "${long[@]}" --out stopped >stdout.txt 2>stderr.txt </dev/null &
pid=$!
while [ "$(cat stopped/history.csv 2>/dev/null | wc -l)" -lt 20 ] && kill -0 "$pid"; do
    sleep 0.02
done
kill -TERM "$(pgrep -f -- "^[^ ]*cpinn-train .*--out stopped" | sort -n | tail -1)"
status=0
wait "$pid" || status=$?
pid=
check exit 143 after SIGTERM -- test "$status" -eq 143
run 3 "${long[@]}" --out stopped --resume
answers long stopped
run 3 by 2 "${deep[@]}" --set 'training.stages=[{optimizer: adam, steps: 100000000, stop: {seconds: 0.5}}]' --out timed

# ---- families and one-step models: work that is dealt ---------------------------------------------

# said_by RANKS STATUS FOLDER OPTION COUNT: what cpinn-eval says of a model is, but for times, what one
# process says.
said_by() {
    local n=$1 status=$2 no_times='s/"[a-z_]*seconds[a-z_0-9]*": [^,}]*//g'
    shift 2
    run "$status" cpinn-eval "$@" --threads 2 --json one.json
    run "$status" by "$n" cpinn-eval "$@" --threads 1 --json several.json
    sed -E "$no_times" one.json >one.txt
    sed -E "$no_times" several.json >several.txt
    same one.txt several.txt
}

# trained_by RANKS STATUS FOLDER COMMAND...: the history of FOLDER, which one process has trained.
trained_by() {
    local n=$1 status=$2 folder=$3
    shift 3
    run "$status" by "$n" "$@" --threads 1 --out "${folder}_$n"
    without_seconds "$folder/history.csv" >one.txt
    without_seconds "${folder}_$n/history.csv" >several.txt
    same one.txt several.txt
}

family=(cpinn-train "$ROOT/configs/robots/tendon_family.yaml" --quiet --set members.solved=500
    --set 'network.hidden=[12]' --set output.every=4 --set 'training.stages=[{optimizer: soap, steps: 8},
        {optimizer: soap, steps: 4, targets: physics}]')
run 3 "${family[@]}" --threads 2 --out family
trained_by 2 3 family "${family[@]}"
trained_by 3 3 family "${family[@]}"
said_by 3 0 family --verify 40
cat >members.csv <<END
tension_1,tension_2,tension_3,turned,vertical,tip_x,tip_y,tip_z,stiffness
1,0,0,0,1,0,0,0,1
2,1,0,1,0,0.1,0,0,1
3,1,2,2,0.5,0,0.1,0,0.7
END
run 0 cpinn-eval family --members members.csv --out shapes.csv
run 0 by 2 cpinn-eval family --members members.csv --out shapes_2.csv
same shapes.csv shapes_2.csv

arm=(cpinn-train "$ROOT/configs/robots/soft_arm_control.yaml" --quiet --set surrogate.kind=polynomial
    --set surrogate.step=0.05 --set 'surrogate.modes=[1, 1, 1, 1]' --set surrogate.solved=500
    --set control.period=0.05 --set 'network.hidden=[8]' --set output.every=2
    --set 'training.stages=[{optimizer: adam, steps: 6}, {optimizer: lbfgs, steps: 3}]')
run 3 "${arm[@]}" --threads 2 --out arm
trained_by 3 3 arm "${arm[@]}"
said_by 2 0 arm_3 --rollouts 5

# ---- words ---------------------------------------------------------------------------------------

run 2 by 2 cpinn-train nowhere.yaml
check one line of error -- test "$(grep -c nowhere.yaml stderr.txt)" -eq 1
run 2 by 2 "${long[@]}" --out long
check one line of error -- test "$(grep -c 'there is a run already' stderr.txt)" -eq 1
run 2 by 2 cpinn-solve "$ROOT/configs/elastica.yaml" --grid 11 --out solved.csv
check one line of error -- test "$(grep -c 'does not share its work' stderr.txt)" -eq 1
check nothing is written -- test ! -e solved.csv
run 2 by 2 cpinn-eval long
check one line of error -- test "$(grep -c 'shares only' stderr.txt)" -eq 1
# Ranks that were given something else: one line says which, and what; nothing is begun.
others=(cpinn-train "$elastica" --quiet --out others --set 'training.stages=[{optimizer: adam, steps: 3}]')
# other_says PATTERN OPTIONS...: two as they are, and one with these options.
other_says() {
    local pattern=$1
    shift
    run 2 timeout 120 mpirun "${over[@]}" -n 2 "${others[@]}" : -n 1 "$@"
    check one line of error -- test "$(grep -c 'rank [0-9]' stderr.txt)" -eq 1
    said stderr.txt "rank 2 is about to do something else than rank 0: $pattern"
    check nothing is begun -- test ! -e others
}
other_says "'--set loads.drag=1' there, 'nothing' on rank 0" "${others[@]}" --set loads.drag=1
other_says "'cpinn-eval .*' there, 'cpinn-train .*' on rank 0" cpinn-eval long
mkdir -p elsewhere
sed 's/length: .*/length: 0.31/' "$elastica" >"elsewhere/$(basename "$elastica")"
other_says "'.*elastica_deep.yaml .[0-9]* bytes, hash " cpinn-train "elsewhere/$(basename "$elastica")" "${others[@]:2}"
for part in . elsewhere; do # the same scene, other measurements
    echo 'data: [{quantity: position, file: measured.csv}]' | cat "$elastica" - >"$part/measured.yaml"
    printf 's,x,y,z\n0.1,0,0,%s\n' "0.1${#part}" >"$part/measured.csv"
done
run 2 timeout 120 mpirun "${over[@]}" -n 1 cpinn-train measured.yaml --out others : \
    -n 1 --wdir elsewhere cpinn-train measured.yaml --out others
said stderr.txt "rank 1 is about to do something else than rank 0: '.*elsewhere/measured.csv.*' there"
run 2 timeout 120 mpirun "${over[@]}" -n 1 cpinn-train measured.yaml --out others : \
    -n 1 cpinn-train measured.yaml --out others --nonsense
said stderr.txt "'--nonsense' there"
run 3 timeout 120 mpirun "${over[@]}" -n 1 "${others[@]}" --threads 1 : -n 1 "${others[@]}" --threads=2

finish
