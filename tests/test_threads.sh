#!/bin/bash
# Every optimiser with two and four threads, to the same bits as with one. Built to watch threads
# (CFLAGS=-fsanitize=thread), a race ends the program with 66.
#   test_threads.sh BIN ROOT [OPTIMIZER|SCENE]      of one alone; else two at a time
set -u
. "$(dirname "$0")/programs.sh"
export TSAN_OPTIONS=halt_on_error=1
if [ $# -lt 3 ]; then
    { echo cantilever_dynamic && echo elastica && optimizers; } |
        xargs -P 2 -I{} bash "$ROOT/tests/test_threads.sh" "$BIN" "$ROOT" {}
    exit
fi

# same_bits NAME STATUS ARGUMENTS...: trained by one, two and four threads.
same_bits() {
    local name=$1 wanted=$2 threads
    shift 2
    for threads in 1 2 4; do
        run "$wanted" cpinn-train "$@" --threads $threads --out $name$threads
        run 0 cpinn-eval $name$threads --out $name$threads.csv
        same $name$threads.csv ${name}1.csv
    done
}

few=(--set losses.interior.points=200 --set losses.held_out_points=40
    --set 'training.stages=[{optimizer: gauss_newton, steps: 2}]')
case $3 in
cantilever_dynamic) # has converged then
    same_bits $3 0 "$ROOT/configs/$3.yaml" "${few[@]}" --set time.duration=0.3
    ;;
elastica) # random waves, which have not
    same_bits $3 3 "$ROOT/configs/$3.yaml" "${few[@]}"
    ;;
*)
    same_bits $3 3 "$elastica" --set 'network.hidden=[8, 8]' --set losses.interior.points=300 \
        --set losses.held_out_points=40 --set "training.stages=[{optimizer: $3, steps: 4}]"
    ;;
esac
finish
