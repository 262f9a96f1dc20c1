#!/bin/sh
# Draws the robots of configs/robots: at rest, in motion, of families some members, in closed loop with
# the reduced rod as the model, as NAME.png beside their scenes, or in FOLDER. Seconds, after
# tools/setup.sh.
#   tools/pictures.sh [FOLDER]
set -eu
cd "$(dirname "$0")/.."
to=${1:-configs/robots}
PATH=$PATH:build/tools
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for scene in configs/robots/*.yaml; do
    name=$(basename "$scene" .yaml)
    case $name in *_published | *_residual) continue ;; esac # the robot of another file
    if grep -q '^control:' "$scene"; then
        cpinn-control "$scene" --set control.model=reduced --quiet --out "$work/$name.csv" ||
            test $? -eq 3 # a warning comes with a loop
        cpinn-show "$work/$name.csv" --scene "$scene" --out "$to/$name.png"
    else
        cpinn-show "$scene" --out "$to/$name.png"
    fi
done
