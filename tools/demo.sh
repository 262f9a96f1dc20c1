#!/bin/sh
# Installs what is missing, builds, trains three rods and evaluates them; where gnuplot is installed
# (tools/setup.sh gnuplot-nox) it draws the picture of the README. Results go to build/demo/, which is
# emptied first.
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
done
build/tools/cpinn-eval build/demo/soft_arm --grid 41x25 --out build/demo/soft_arm.csv >/dev/null
if command -v gnuplot >/dev/null; then
    (cd build/demo && gnuplot ../../configs/soft_arm.gp)
fi
echo
echo "demo: checkpoints, histories, evaluations and soft_arm.svg are in build/demo/"
