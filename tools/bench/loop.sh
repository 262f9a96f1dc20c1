#!/bin/bash
# An exported loop of a robot that follows a circle about z: how long a sample takes, and in real time
# against the simulated robot in another process, with the jitter of both.
#   tools/bench/loop.sh CONFIG RUN INNER [FILE.csv]     from the root of the project, which is built
# RUN and INNER are trained one-step models of CONFIG, INNER (or "") one of steps of 1 ms: then samples
# are taken at 1 kHz, else once a step. FILE.csv: the histogram of the times.
set -u
cd "$(dirname "$0")/../.." || exit 2
PATH=$PWD/build/tools:$PWD/build/tools/bench:$PATH
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
samples=100000 seconds=30
fast=()
[ -z "$3" ] || fast=(--set control.period=0.001)
cpinn-control "$1" --run "$2" ${3:+--inner "$3"} "${fast[@]}" --set control.duration=6 --c "$work/arm" \
    >"$work/said" || exit 1
grep -E 'task|model|rms|step|wrote' "$work/said"
read -r radius hz x y z < <(sed -nE \
    's/.*circle of ([0-9.e-]+) mm at ([0-9.e-]+) Hz about \(([^,]+), ([^,]+), ([^)]+)\).*/\1 \2 \3 \4 \5/p' \
    "$work/said")
for program in time host; do
    cc -std=c11 -O2 -DHEADER='"arm.h"' -DNAME=arm -I"$work" -o "$work/$program" \
        "tools/bench/loop_$program.c" "$work/arm.c" -lm || exit 1
done
echo && "$work/time" "$samples" "$hz" || exit 1
echo && "$work/time" "$samples" 10 || exit 1 # faster than it can follow: inputs at their limits
echo && loop_plant "$1" "${fast[@]}" &
sleep 0.3
"$work/host" "$seconds" "$x" "$y" "$z" "$(awk "BEGIN { print $radius / 1000 }")" "$hz" "${4:-$work/histogram.csv}"
wait
