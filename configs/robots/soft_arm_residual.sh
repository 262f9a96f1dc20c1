#!/bin/sh
# Six loops of soft_arm_residual.yaml without its residual, the last of which is not trained on, and
# what is learned from them.
#
#     PATH=build/tools:$PATH configs/robots/soft_arm_residual.sh
set -eu
folder=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for task in "circle 0.013 0.5" "circle 0.02 0.4" "eight 0.015 0.3" "circle 0.008 0.8" \
    "eight 0.02 0.5" "circle 0.017 0.6"; do
    set -- $task
    cpinn-control "$folder/soft_arm_residual.yaml" --set control.residual=null \
        --set "control.task={path: $1, radius: $2, frequency: $3}" --set control.duration=6 \
        --quiet --out "$work/loop.csv" || [ $? = 3 ] # the model is off, and that is said
    [ -f "$work/measured.csv" ] || head -1 "$work/loop.csv" >"$work/measured.csv"
    tail -n +2 "$work/loop.csv" >>"$work/measured.csv"
done
cpinn-residual "$folder/soft_arm_residual.yaml" --measured "$work/measured.csv" --held-out 1 \
    --noise 2e-4 --units 3 --out "$folder/soft_arm_residual.h5"
