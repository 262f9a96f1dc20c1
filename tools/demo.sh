#!/bin/sh
# Installs what is missing, builds, trains three rods, evaluates and draws them. Results go to
# build/demo/, which is emptied first.
#   tools/demo.sh [OPTIONS OF cpinn-train...]
set -eu
cd "$(dirname "$0")/.."
tools/setup.sh

rm -rf build/demo
mkdir -p build/demo
for name in elastica cantilever_dynamic soft_arm; do
    echo
    echo "== cpinn-train configs/$name.yaml"
    build/tools/cpinn-train "configs/$name.yaml" --out "build/demo/$name" "$@" ||
        test $? -eq 3 # a warning comes with an answer
    echo
    echo "== cpinn-eval build/demo/$name"
    build/tools/cpinn-eval "build/demo/$name" --out "build/demo/$name/evaluation.csv"
    build/tools/cpinn-show "build/demo/$name" --out "build/demo/$name.png"
done
echo
echo "demo: checkpoints, histories, evaluations and pictures are in build/demo/"
