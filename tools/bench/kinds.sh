#!/bin/bash
# Kinds of one-step models of one robot side by side: each is trained on one core by its defaults, and
# judged by the same fresh rollouts. Prints, and with --out DIR draws, error over run time.
#   tools/bench/kinds.sh SCENE [--out DIR] [--seeds "1 2"] [--kinds "flow polynomial"] [cpinn-train options...]
set -u
root=$(cd "$(dirname "$0")/../.." && pwd) || exit 2
PATH=$root/build/tools:$PATH
scene=${1:?"a scene is missing: kinds.sh SCENE"}
shift
out= seeds="1 2" options=()
kinds="linear flow polynomial"
while [ $# -gt 0 ]; do
    case $1 in
    --out) out=${2:?"--out: a folder is missing"} && shift 2 ;;
    --seeds) seeds=${2:?"--seeds: numbers are missing"} && shift 2 ;;
    --kinds) kinds=${2:?"--kinds: names are missing"} && shift 2 ;;
    *) options+=("$1") && shift ;;
    esac
done
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
if [ -n "$out" ]; then
    mkdir -p "$out" || exit 1
fi
TIMEFORMAT=%U
printf 'error of the tip in %% of the length, median / worst; CPU seconds of one core; us of one step\n'
printf '%-16s %4s %8s %18s %18s %8s %7s %8s\n' kind seed training 'one step' '5 s' diverged step Jacobian
status=0
for kind in $kinds reduced_rod; do
    for seed in $seeds; do
        if [ "$kind" = reduced_rod ]; then # the last model's table has it beside
            row=$(grep '^reduced rod in one step' "$work/log" | sed 's/^reduced rod in one step//')
            training=0
        else
            rm -rf "$work/run"
            { time cpinn-train "$scene" --threads 1 --out "$work/run" --set "surrogate.kind=$kind" \
                --set "training.seed=$seed" "${options[@]}" >"$work/log" 2>"$work/error"; } 2>"$work/time"
            training=$(tail -1 "$work/time")
            row=$(grep "^$kind  " "$work/log" | sed "s/^$kind//")
        fi
        if [ -z "$row" ]; then
            cat "$work/error" >&2
            status=1
            continue
        fi
        # states, one step, 5 s, 1000 steps (m / w, or - where it diverged), diverged, one, 147, Jacobian
        printf '%s %s %s %s\n' "$kind" "$seed" "$training" "$row" | sed 's| / |/|g' | awk -v data="$work/data" '{
            long = $6; sub("/", " / ", $5); short = $6; sub("/", " / ", short)
            printf "%-16s %4s %8.0f %18s %18s %8s %7s %8s\n", $1, $2, $3, $5, short, $8, $9, $11
            split(long, error, "/")
            if (long != "-") print $1, $3, error[1], $9 >> data
        }'
        [ "$kind" = reduced_rod ] && break
    done
done
if [ -n "$out" ] && [ -s "$work/data" ]; then
    cp "$work/data" "$out/kinds.txt" # kind, CPU seconds of training, error after 5 s in %, us a step
    cat >"$out/kinds.gp" <<'GP'
set terminal svg size 900,420 font "sans,12"
set output "kinds.svg"
set logscale
set multiplot layout 1,2
set ylabel "error of the tip after 5 s, % of the length (median)"
set offsets graph 0.15, graph 0.15, graph 0.1, graph 0.1
unset key
set xlabel "training, CPU s"
plot "< awk '$2 > 0' kinds.txt" using 2:3:1 with labels point pointtype 7 offset 0,0.8
set xlabel "a step, us"
plot "kinds.txt" using 4:3:1 with labels point pointtype 7 offset 0,0.8
GP
    (cd "$out" && gnuplot kinds.gp) || status=1
fi
exit $status
