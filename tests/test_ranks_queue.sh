#!/bin/bash
# Many runs over processes that mpirun has started: the same table for any number of them, but for
# times; errors, signals and processes that die.
#   test_ranks_queue.sh BIN ROOT QUEUE_JOBS HAS_MPI
set -u
. "$(dirname "$0")/programs.sh"
jobs=$3

# ---- without mpirun ---------------------------------------------------------------------------

run 0 "$jobs" 30
cp stdout.txt alone
check 30 jobs -- test "$(wc -l <alone)" -eq 30
run 2 "$jobs" 30 fails 12
same <(head -12 alone) stdout.txt
said stderr.txt '^queue_jobs: job 12: is one that fails$'
if [ "$4" != 1 ] || ! command -v mpirun >/dev/null; then
    [ "$failures" -eq 0 ] && echo 'without mpirun: skipped' && exit 77
    finish
fi

export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_orte_execute_quiet=1

ranks() {
    local count=$1
    shift
    timeout 100 mpirun -n "$count" "$@"
}

# told PATTERN COMMAND...: exit 2 and one line of that pattern, beside what mpirun says.
told() {
    local pattern=$1
    shift
    run 2 "$@"
    check one line -- test "$(grep -cE -- "$pattern" stderr.txt)" -eq 1
}

# ---- the queue --------------------------------------------------------------------------------

for count in 1 2 3; do
    run 0 ranks $count "$jobs" 30
    same alone stdout.txt
    run 2 ranks $count "$jobs" 30 fails 12
    same <(head -12 alone) stdout.txt
    said stderr.txt '^queue_jobs: job 12: is one that fails$'
done
run 0 ranks 3 "$jobs" 1
same <(head -1 alone) stdout.txt
run 2 ranks 3 "$jobs" 30 leaves 1 # the others do its work, and the error is told
same alone stdout.txt
said stderr.txt '^queue_jobs: rank 1: queue_jobs: rank 1 leaves$'
run 2 ranks 3 "$jobs" 30 leaves 0
check nothing done -- test ! -s stdout.txt
said stderr.txt '^queue_jobs: rank 0 leaves$'

# One that dies: mpirun ends the others, and what is done is there. They have time to say so, also on a
# machine that does much else.
export OMPI_MCA_odls_base_sigkill_timeout=3
run 137 ranks 3 "$jobs" 400 dies 1
said stderr.txt '^queue_jobs: warning: stopped by signal 15, or since a rank has ended: [1-9][0-9]* of 400 rows are done$'
check rows before it -- test "$(wc -l <stdout.txt)" -ge 10
check rows in order -- sort -nc -t : stdout.txt
unset OMPI_MCA_odls_base_sigkill_timeout

# ---- the programs -----------------------------------------------------------------------------

# Columns that are no times of a table, by their names.
timeless() {
    awk -F, -v OFS=, 'NR == 1 { for (i = 1; i <= NF; i++) time[i] = $i ~ /second/ }
        { for (i = 1; i <= NF; i++) if (time[i]) $i = "-" } 1' "$1"
}

mkdir few
cp "$ROOT/configs/elastica.yaml" few/b_bent.yaml
sed 's/elastica/nothing/' "$ROOT/configs/elastica.yaml" >few/c_wrong.yaml
cp "$ROOT/configs/beam_cantilever.yaml" few/a_beam.yaml
tiny=(--set losses.interior.points=16 --set losses.held_out_points=16 --threads 1 --seconds 60)
for count in 1 3; do
    run 1 ranks $count cpinn-cases few --threads 1 --out cases$count
    check six rows -- test "$(grep -cE '^(a_beam|b_bent|c_wrong) |^ +(collocation|solver) ' stdout.txt)" -eq 6
    same <(timeless cases1/cases.csv) <(timeless cases$count/cases.csv)
    run 0 ranks $count cpinn-bench "$elastica" "${tiny[@]}" --methods a=adam:20,b=adam:5+lbfgs:9 \
        --networks 1x4 --seeds 2 --out bench$count
    check four runs -- test "$(grep -c '\[[1-4]/4\] elastica_deep ' stdout.txt)" -eq 4
    same <(timeless bench1/summary.csv) <(timeless bench$count/summary.csv)
    same bench1/about.txt bench$count/about.txt
done
told '^cpinn-cases: .*missing.yaml: No such file' ranks 2 cpinn-cases few missing.yaml
told 'cases1: there is a table already' ranks 2 cpinn-cases few --out cases1
told '^--error tops: allowed' ranks 2 cpinn-bench "$elastica" --error tops
told '^cpinn-law: .*share' ranks 2 cpinn-law "$elastica"

# What mpirun ends, on Ctrl-C as well, writes what is done.
OMPI_MCA_odls_base_sigkill_timeout=10 \
    mpirun -n 2 cpinn-cases few/a_beam.yaml "$dynamic" --threads 1 --out stopped \
    >stdout.txt 2>stderr.txt </dev/null &
pid=$!
for _ in $(seq 600); do
    [ "$(grep -cE '^a_beam |^ +collocation' stdout.txt)" -ge 2 ] && break
    sleep 0.1
done
kill -TERM $pid
got=0
wait $pid || got=$?
pid=
check not 0 after SIGTERM -- test $got -ne 0
said stderr.txt '^cpinn-cases: warning: stopped by signal 15, .*: [23] of 4 rows are done$'
check rows -- test "$(grep -c '^a_beam,' stopped/cases.csv)" -eq 2
finish
