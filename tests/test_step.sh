#!/bin/bash
# The benchmark of one training step: that its sides compute the same, not how long they take.
#   test_step.sh BIN ROOT alone|peers
# CPINN_PYTHON: the Python of the peers, else python3.
set -u
PATH=$1:$PATH
step=$(realpath "$2")/tools/bench/step.py
python=${CPINN_PYTHON:-python3}
unset OPENBLAS_CORETYPE OPENBLAS_L2_SIZE
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
cd "$folder" || exit 1

fail()
{
    echo "$1"
    cat table.txt
    exit 1
}

command -v python3 >/dev/null || exit 77
if [ "$3" = alone ]; then
    # 72 points: tiles that are not full; compiled and interpreted, two threads and one
    "$step" --points 72 --rounds 1 >table.txt 2>&1 || fail "step does not end well"
    [ "$(grep -c '^tape' table.txt)" = 4 ] || fail "the table has not four rows"
    "$step" --points 72 --normal-points 8 --rounds 1 --peers --python no-such-python \
        >table.txt 2>&1 || fail "missing peers are an error"
    [ "$(grep -c 'not installed: no-such-python' table.txt)" = 11 ] || fail "rows of missing peers"
    exit 0
fi
if ! "$python" -c 'import numpy, torch, jax' 2>/dev/null; then
    echo "skipped: $python has no numpy, torch and jax"
    exit 77
fi
# What JAX compiles without optimising it is there in less time, and says the same.
export XLA_FLAGS=--xla_backend_optimization_level=0
"$step" --points 512 --normal-points 16 --rounds 1 --peers --python "$python" \
    >table.txt 2>&1 || fail "step failed"
missing=0 # but for the row of PyTorch that needs torch.func, which PyTorch 1 does not have
"$python" -c 'from torch import func' 2>/dev/null || missing=1
[ "$(grep -c failed table.txt)" = 0 ] || fail "a peer does not agree"
[ "$(grep -c 'not installed' table.txt)" = $missing ] || fail "a peer is missing"
