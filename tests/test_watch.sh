#!/bin/bash
# cpinn-watch: of a run that goes on and of one that has ended.
#   test_watch.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"
command -v python3 >/dev/null || exit 77

# ---- a run that has ended: a loss that falls by a decade a second is a straight line -------------

mkdir ended
awk 'BEGIN { print "step,seconds,loss,held_out,error"
    for (i = 0; i <= 40; i++) printf "%d,%g,%g,,%s\n", i, i / 10, 10^(-i / 10), i % 10 ? "" : 10^(-i / 5) }' \
    >ended/history.csv
run 0 env COLUMNS=80 LINES=30 cpinn-watch ended
said stdout.txt '^ended: step 40 in 4.00 s, loss 1.00e-04, error 1.00e-08$'
said stdout.txt '^ *1e0 '
said stdout.txt '^ *1e-8 '
said stdout.txt ' loss \*'
said stdout.txt ' error #'
check nothing that is not there -- test "$(grep -c held-out stdout.txt)" -eq 0
check the size -- awk 'length > 79 { exit 1 } END { exit NR > 28 }' stdout.txt
check no control sequences -- test -z "$(tr -cd '\033' <stdout.txt)"
# From its first column to its last the loss falls by four of the eight decades: half of the height.
check the loss is a line half as steep as the error -- awk '/\*/ && !/loss/ { if (!first) first = NR; last = NR }
    /^ *1e0 / { top = NR } /^ *1e-8 / { bottom = NR }
    END { half = (bottom - top) / 2; exit !(last - top >= half - 1 && last - top <= half + 1) }' stdout.txt

# ---- one that goes on --------------------------------------------------------------------------

cpinn-train "$dynamic" --set 'network.hidden=[8]' --set losses.interior.points=48 --threads 1 --quiet \
    --set 'training.stages=[{optimizer: adam, steps: 100000000}]' --out going >/dev/null 2>&1 &
pid=$!
for ((i = 0; i < 400; i++)); do
    [ "$(wc -l 2>/dev/null <going/history.csv)" -gt 3 ] 2>/dev/null && break
    sleep 0.05
done
run 0 cpinn-watch going --once
said stdout.txt '^going: step [1-9][0-9]* in [0-9.]+ s, loss '
cpinn-watch going >watched.txt 2>&1 &
watcher=$!
sleep 1
check it watches -- kill -0 "$watcher"
kill -TERM "$pid"
wait "$pid"
pid=
status=0
wait "$watcher" || status=$?
check it ends with the run -- test "$status" -eq 0
check one picture in a pipe -- test "$(grep -c '^going: step' watched.txt)" -eq 1
step=$(awk -F, 'END { print $1 }' going/history.csv)
said watched.txt "^going: step $step in "

# ---- what is refused ---------------------------------------------------------------------------

run 0 cpinn-watch --help
said stdout.txt '^usage: cpinn-watch '
refused '^cpinn-watch: nowhere: there is no run' cpinn-watch nowhere --once
refused '^cpinn-watch: DIR is missing' cpinn-watch
mkdir empty
ln -s "$(command -v python3)" empty/
run 1 env PATH="$PWD/empty" python3 "$BIN/cpinn-watch" ended
said stderr.txt 'gnuplot is not installed'

finish
