#!/bin/bash
# Training by 1, 2 and 4 ranks of one thread and by one rank of two threads: the measured time of a step, and how
# long ranks waited.
#   tools/bench/ranks.sh [REPEATS [FILE.csv]]     from the root of the project, which is built with MPI
# REPEATS: 5; each takes about a minute on two processors. FILE.csv: every number. Times are medians
# over the rows of history and over the repeats.
set -u
cd "$(dirname "$0")/../.." || exit 2
PATH=$PWD/build/tools:$PATH
repeats=${1:-5} table=${2:-}
[[ $repeats =~ ^[1-9][0-9]*$ ]] || { echo "ranks.sh: $repeats: a number of repeats, at least 1" >&2; exit 2; }
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
export XDG_CACHE_HOME=$work/cache # no compiled programs of earlier runs
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 # in containers
flags=()
mpirun --version | grep -q 'Open MPI' && flags=(--oversubscribe --bind-to none)

quick=(--set reference=null --set losses.held_out_points=64)
deep=(configs/cantilever_deep.yaml "${quick[@]}" --set output.every=20
    --set 'training.stages=[{optimizer: adam, steps: 1000}]')
wide=(configs/cantilever_deep.yaml "${quick[@]}" --set output.every=1 --set 'network.hidden=[220, 220, 220]'
    --set losses.interior.points=32768 --set 'training.stages=[{optimizer: adam, steps: 6}]')
gauss_newton=(configs/cantilever_deep.yaml "${quick[@]}" --set output.every=1 --set 'network.hidden=[24, 24]'
    --set 'training.stages=[{optimizer: gauss_newton, steps: 15}]') # hardly ever with a J that was kept

# by RANKS COMMAND...
by() {
    local n=$1
    shift
    if [ "$n" -eq 1 ]; then "$@"; else mpirun "${flags[@]}" -n "$n" "$@"; fi
}

# Milliseconds of a step: the median over the rows of a history but the first.
step_of() {
    awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
        NR > 2 { print 1000 * ($at["seconds"] - before) / ($at["step"] - last) }
        { before = $at["seconds"]; last = $at["step"] }' "$1" | median
}

median() {
    sort -g | awk '{ x[NR] = $1 } END { print (x[int((NR + 1) / 2)] + x[int(NR / 2) + 1]) / 2 }'
}

# run CASE RANKS THREADS ARGUMENTS...: appends "step least most" to its file of measurements
run() {
    local case=$1 n=$2 t=$3 said
    shift 3
    rm -rf "$work/run"
    said=$(by "$n" cpinn-train "$@" --threads "$t" --out "$work/run" 2>"$work/stderr")
    case $? in 0 | 3) ;; *) cat "$work/stderr" >&2 && exit 1 ;; esac
    said=$(sed -nE 's/.*ranks waited ([0-9.]+) to ([0-9.]+) %.*/\1 \2/p' <<<"$said" | tail -1)
    echo "$(step_of "$work/run/history.csv") ${said:-0 0}" >>"$work/$case.$n.$t"
}

column() { # of the measurements of a case
    cut -d ' ' -f "$1" "$2" | median
}

ways=("1 1" "1 2" "2 1" "4 1")
echo "load $(cut -d ' ' -f 1 /proc/loadavg), $(getconf _NPROCESSORS_ONLN) processors, $repeats repeats" >&2
for ((i = 0; i < repeats; i++)); do
    for case in deep wide gauss_newton; do
        declare -n arguments=$case
        for way in "${ways[@]}"; do
            run "$case" ${way} "${arguments[@]}"
        done
    done
done
[ -z "$table" ] || echo "case,ranks,threads,step_ms,waited_least,waited_most" >"$table"
printf '%-13s%6s%9s%10s%12s\n' case ranks threads 'step, ms' waited
for case in deep wide gauss_newton; do
    for way in "${ways[@]}"; do
        read -r n t <<<"$way"
        measured=$work/$case.$n.$t
        step=$(column 1 "$measured") least=$(column 2 "$measured") most=$(column 3 "$measured")
        printf '%-13s%6d%9d%10.3f%10.1f %%\n' "$case" "$n" "$t" "$step" "$most"
        [ -z "$table" ] || echo "$case,$n,$t,$step,$least,$most" >>"$table"
    done
    awk -v c="$case" -v a="$(column 1 "$work/$case.2.1")" -v b="$(column 1 "$work/$case.1.2")" \
        'BEGIN { printf "%-13stwo ranks of one thread take %.3f times as long as one of two threads\n", c, a / b }'
done
echo "load $(cut -d ' ' -f 1 /proc/loadavg)" >&2
