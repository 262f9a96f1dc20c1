#!/bin/bash
# Every optimiser with two and four threads, to the same bits as with one. Built to watch threads
# (CFLAGS=-fsanitize=thread), a race ends the program with 66.
#   test_threads.sh BIN ROOT [OPTIMIZER]      of one of them, alone
set -u
. "$(dirname "$0")/programs.sh"
export TSAN_OPTIONS=halt_on_error=1

small=(--set 'network.hidden=[8, 8]' --set losses.interior.points=300
    --set losses.held_out_points=40)
for optimizer in ${3-$(optimizers)}; do
    for threads in 1 2 4; do
        run 3 cpinn-train "$elastica" "${small[@]}" --threads $threads --out $optimizer$threads \
            --set "training.stages=[{optimizer: $optimizer, steps: 4}]"
        run 0 cpinn-eval $optimizer$threads --grid 9 --out $optimizer$threads.csv
        same $optimizer$threads.csv ${optimizer}1.csv
    done
done
[ $# -lt 3 ] || { finish; exit; }
for threads in 1 2 4; do # the default: random waves, and a motion
    wanted=3 # a motion has converged after two steps, a rod at rest not
    for scene in elastica cantilever_dynamic; do
        run $wanted cpinn-train "$ROOT/configs/$scene.yaml" --threads $threads --out $scene$threads \
            --set 'training.stages=[{optimizer: gauss_newton, steps: 2}]' \
            --set losses.interior.points=200 --set losses.held_out_points=40
        run 0 cpinn-eval $scene$threads --out $scene$threads.csv
        same $scene$threads.csv ${scene}1.csv
        wanted=0
    done
done
finish
