#!/bin/bash
# Runs that are stopped, killed and resumed; checkpoints that are damaged.
#   test_resume.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"

steps=4000 # of each stage: about a second in all, so that there is time to interrupt it
watched && steps=2000
scene=(--set 'network.hidden=[8, 8]' --set losses.interior.points=48
    --set losses.held_out_points=16 --set losses.interior.sampler=uniform
    --set losses.interior.resample_every=700 --set enforcement.initial=soft
    --set losses.causal.slices=3 --set losses.causal.update_every=150
    --set "training.stages=[{optimizer: adam, steps: $steps}, {optimizer: lbfgs, steps: $steps}]")
often=(--set checkpoint.every=97 --set output.every=10)

train=(cpinn-train "$dynamic" "${scene[@]}" "${often[@]}" --threads 1)

rows() {
    if [ -e "$1/history.csv" ]; then wc -l <"$1/history.csv"; else echo 0; fi
}

# background FOLDER ROWS OPTIONS...: train in the background until history.csv has so many rows.
background() {
    local folder=$1 wanted=$2
    shift 2
    "${train[@]}" --out "$folder" "$@" >stdout.txt 2>stderr.txt </dev/null &
    pid=$!
    while [ "$(rows "$folder")" -lt "$wanted" ] && kill -0 "$pid" 2>/dev/null; do
        sleep 0.01
    done
}

# ended SIGNAL: send it, and wait; leaves the exit status.
ended() {
    kill "-$1" "$pid" 2>/dev/null || echo "note: the run was over before it could be stopped"
    status=0
    wait "$pid" 2>/dev/null || status=$?
    pid=
}

# The run agrees with the uninterrupted one.
check_whole() {
    run 0 cpinn-eval "$1" --grid 21x11 --out "$1.csv"
    same "$1.csv" whole.csv
    check_history "$1/history.csv"
    without_seconds "$1/history.csv" >"$1.history"
    same "$1.history" whole.history
}

run 3 "${train[@]}" --out whole # so short a training has not converged
run 0 cpinn-eval whole --grid 21x11 --out whole.csv
without_seconds whole/history.csv >whole.history
total=$(tail -1 whole/history.csv | cut -d, -f1)
check both stages have worked -- test "$total" -gt $((steps + 500))

# ---- a run that is over -----------------------------------------------------------------------

run 3 "${train[@]}" --out whole --resume
said stdout.txt 'nothing is left to do'
check_whole whole

# ---- signals ----------------------------------------------------------------------------------

# The command that it names continues it.
follow() {
    local command
    command=$(grep '^  cpinn-train ' stdout.txt)
    check it says how to continue -- test -n "$command"
    eval "$command --threads 2" >stdout.txt 2>stderr.txt </dev/null
    [ $? -eq 3 ] || failed "$command"
    said stdout.txt 'resumed at step [1-9]'
}

background "it's int" $((total / 10 / 5)) # in the middle of Adam
ended INT
check SIGINT gives 130 -- test "$status" -eq 130
said stdout.txt 'stopped at step [1-9][0-9]* and saved; continue with'
check nothing on stderr -- test ! -s stderr.txt
follow
mv "it's int" int
check_whole int

background term $(((total + steps) / 2 / 10)) # in the middle of L-BFGS
ended TERM
check SIGTERM gives 143 -- test "$status" -eq 143
follow
check_whole term

background quiet $((total / 10 / 5)) --quiet
ended INT
check quiet says nothing -- test "$status" -eq 130 -a ! -s stdout.txt -a ! -s stderr.txt

# A terminal that closes, and queues that warn before the time is over: again and again, which is no
# reason to stop before the checkpoint is there.
for signal in HUP $(watched || echo USR1 USR2 XCPU); do
    background $signal $(((total + steps) / 2 / 10))
    kill -$signal "$pid"
    kill -$signal "$pid"
    ended $signal
    check exit status of SIG$signal -- test "$status" -eq $((128 + $(kill -l $signal)))
    said stdout.txt 'stopped at step [1-9][0-9]* and saved; continue with'
    check nothing on stderr -- test ! -s stderr.txt
    follow
    check_whole $signal
done
# What nohup has switched off stays so.
(trap '' HUP && exec "${train[@]}" --out nohup >stdout.txt 2>stderr.txt </dev/null) &
pid=$!
while [ "$(rows nohup)" -lt $((total / 10 / 5)) ]; do
    sleep 0.01
done
ended HUP
check nohup goes on -- test "$status" -eq 3
check_whole nohup

# A limit of the size of files is an error like a full disk, and no signal.
last=$(($(wc -c <whole/checkpoint.h5) / 1024)) # which grows with the history
for blocks in 1 $(watched || echo $((last / 2)) 16 $((last * 9 / 10))); do
    got=0
    (ulimit -f $blocks && exec "${train[@]}" --out limited$blocks) >stdout.txt 2>stderr.txt || got=$?
    check exit 1 with files of $blocks KiB -- test "$got" -eq 1
    check one line of a limit -- test "$(wc -l <stderr.txt)" -eq 1
    said stderr.txt 'File too large'
    [ -z "$(find limited$blocks -name '*.partial')" ] || failed "partial files under a limit"
    option=
    test -e limited$blocks/checkpoint.h5 && option=--resume
    run 3 "${train[@]}" --out limited$blocks $option
    check_whole limited$blocks
done

# ---- kill -9 ----------------------------------------------------------------------------------

# Again and again, in both stages and around the step from one to the other.
background killed $((total / 10 / 10))
ended KILL
for tenth in 3 5 7 9; do
    background killed $((total * tenth / 100)) --resume
    ended KILL
    run 0 cpinn-eval killed
done
run 3 "${train[@]}" --out killed --resume
check_whole killed

# While it starts: either nothing is there and the run can begin, or it can be resumed.
for delay in 0 0.01 0.02 0.03 0.05 0.08; do
    "${train[@]}" --out early >/dev/null 2>&1 </dev/null &
    pid=$!
    sleep "$delay"
    ended KILL
    option=
    test -e early/checkpoint.h5 && option=--resume
    run 3 "${train[@]}" --out early $option --set 'training.stages[0].steps=20' \
        --set 'training.stages[1].steps=20'
    rm -rf early
done

# ---- two processes ----------------------------------------------------------------------------

# One folder is for one of them, and the other's run goes on undisturbed; a killed one lets go.
background shared $((total / 10 / 10))
got=0
"${train[@]}" --out shared --resume >other.txt 2>&1 </dev/null || got=$?
check the second of two processes -- test "$got" -eq 2
said other.txt '^shared: in use by another process; '
rm shared/lock
got=0
"${train[@]}" --out shared --resume >other.txt 2>&1 </dev/null || got=$?
check the second without a file lock -- test "$got" -eq 2
said other.txt '^shared: in use by another process; '
ended KILL
run 3 "${train[@]}" --out shared --resume
check_whole shared

# Nothing is written to a folder that has taken the place of the run's.
background moved $((total / 10 / 10)) --set checkpoint.every=1000
kill -STOP "$pid"
mv moved aside
"${train[@]}" --out moved >other.txt 2>&1 </dev/null # from the beginning
ended CONT
check the first ends -- test "$status" -eq 1
check one line of a folder that has gone -- test "$(wc -l <stderr.txt)" -eq 1
said stderr.txt '^cpinn-train: moved: is no longer the folder that this run began in; '
check_whole moved
run 3 "${train[@]}" --out aside --resume
check_whole aside

# Descriptors that are closed are not those of the run's files.
got=0
"${train[@]}" --out closed >&- 2>&- <&- || got=$?
check nowhere to print -- test "$got" -eq 1
check_history closed/history.csv

# Kernels for another processor (any x86 has those of Nehalem) are told of.
OPENBLAS_CORETYPE=Nehalem run 3 "${train[@]}" --out shared --resume
said stdout.txt "kernels are those of Nehalem here"

# ---- another experiment -----------------------------------------------------------------------

background other $((total / 10 / 10))
ended INT
before=$(contents other)
refused 'other/checkpoint.h5: training.seed: 1 in the checkpoint, 2 now; ' \
    "${train[@]}" --out other --resume --set training.seed=2
refused 'loads.drag: 0 in the checkpoint, 0.5 now; ' \
    "${train[@]}" --out other --resume --set loads.drag=0.5
refused 'stages\[0\].optimizer: adam in the checkpoint, lbfgs now; the stage at work' \
    "${train[@]}" --out other --resume --set 'training.stages=[{optimizer: lbfgs, steps: 9}]'
refused 'rod.model: cosserat in the checkpoint, kirchhoff now; ' \
    cpinn-train "$elastica" --out other --resume
check a refusal changes nothing -- test "$before" = "$(contents other)"
run 3 "${train[@]}" --out other --resume --set name=renamed --set checkpoint.every=50 \
    --set output.every=5 --set 'training.stages[0].learning_rate=1e-3' \
    --set 'training.stages[0].steps=900' --set 'training.stages[1].steps=30'
refused 'stages\[0\].steps: 900 in the checkpoint, 901 now; this stage is over' \
    "${train[@]}" --out other --resume --set 'training.stages[0].learning_rate=1e-3' \
    --set 'training.stages[0].steps=901' --set 'training.stages[1].steps=30'
run 3 "${train[@]}" --out other --resume --set 'training.stages=[
    {optimizer: adam, steps: 900, learning_rate: 1e-3}, {optimizer: lbfgs, steps: 30},
    {optimizer: lbfgs, steps: 20}]' # a run that was over goes on with a new stage
said stdout.txt 'stage 3 ended at step'
check_history other/history.csv

# ---- damaged checkpoints ----------------------------------------------------------------------

size=$(wc -c <other/checkpoint.h5)
mkdir bad && cp other/checkpoint.h5 good.h5
for kept in 0 1 100 511 512 2000 $((size / 2)) $((size - 1)); do
    head -c "$kept" good.h5 >bad/checkpoint.h5
    refused 'bad/checkpoint.h5: ' "${train[@]}" --out bad --resume
    refused 'bad/checkpoint.h5: ' cpinn-eval bad
done
for at in 0 20 300 600 $((size / 3)) $((size / 2)) $((size - 1)); do
    cp good.h5 bad/checkpoint.h5
    byte=$(od -An -tu1 -j "$at" -N 1 good.h5)
    printf "\\$(printf %03o $((byte ^ 255)))" |
        dd of=bad/checkpoint.h5 bs=1 seek="$at" conv=notrunc 2>/dev/null
    refused 'bad/checkpoint.h5: ' "${train[@]}" --out bad --resume
    refused 'bad/checkpoint.h5: ' cpinn-eval bad
done
echo 'not a checkpoint' >bad/checkpoint.h5
refused 'bad/checkpoint.h5: ' "${train[@]}" --out bad --resume
rm bad/checkpoint.h5
refused 'bad/checkpoint.h5: ' "${train[@]}" --out bad --resume
mkdir bad/checkpoint.h5
refused 'bad/checkpoint.h5' "${train[@]}" --out bad --resume
refused 'there is a run already' "${train[@]}" --out bad

# The older generations are whole checkpoints too.
check older generations are kept -- test -s other/checkpoint.1.h5
run 0 cpinn-eval other/checkpoint.1.h5

finish
