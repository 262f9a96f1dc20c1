#!/bin/bash
# One rod in motion, that of cantilever_dynamic.yaml, by every form: the usual recipe for physics-informed
# networks as pinn_classic.yaml has it, what each of its choices is worth, the other forms, and solvers.
#   forms.sh [--quick]
# --quick trains a hundred times less, to see that it runs.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
PATH=$PATH:$root/build/tools
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
steps=(--set training.stages[0].steps=3000 --set training.stages[1].steps=6000)
all=()
if [ "${1:-}" = --quick ]; then
    steps=(--set training.stages[0].steps=30 --set training.stages[1].steps=60)
    all=("${steps[@]}")
fi

number() { # of the last --json: key
    grep -o "\"$1\": [^,}]*" "$work/json" | head -1 | awk '{ printf "%.1e", $2 }'
}

# what, key of the estimated error, command: one row, with the seconds of the processor.
row() {
    local what=$1 estimate=$2 verdict
    shift 2
    TIMEFORMAT='%U %S'
    { time "$@" --quiet --json "$work/json" >/dev/null 2>&1 || [ $? -eq 3 ]; } 2>"$work/seconds"
    verdict=$(grep -o '"outcome": "[a-z]*"' "$work/json" | head -1 | cut -d'"' -f4)
    printf '%-56s %8s %9s %7s  %s\n' "$what" "$(number position_max_over_length)" \
        "$(number "$estimate")" "$(awk '{ printf "%.3g", $1 + $2 }' "$work/seconds")" "$verdict"
    rm -rf "$work/run" "$work/json"
}

train() { # what, scene, options
    local what=$1 scene=$2
    shift 2
    row "$what" estimate cpinn-train "$root/configs/$scene.yaml" --threads 1 --out "$work/run" "$@"
}

solve() {
    local what=$1
    shift
    row "$what" estimated_error_max cpinn-solve "$root/configs/cantilever_dynamic.yaml" "$@"
}

printf '%-56s %8s %9s %7s  %s\n' "largest error of position, of the length" error estimate "CPU, s" \
    verdict
train "pinn_classic.yaml" pinn_classic "${all[@]}"
train "  after 3000 steps of Adam, 6000 of L-BFGS" pinn_classic "${steps[@]}"
train "    tanh in place of sin" pinn_classic "${steps[@]}" --set network.activation=tanh
train "    no causal weights" pinn_classic "${steps[@]}" --set losses.causal.slices=0
train "    r and q alone: displacement form" pinn_classic "${steps[@]}" --set formulation=displacement
train "    in its plane: an angle for the quaternion" pinn_classic "${steps[@]}" --set motion=automatic
train "    ends and initial state exact" pinn_classic "${steps[@]}" \
    --set 'enforcement={boundary: hard, initial: hard}'
train "mixed form by random waves" cantilever_dynamic --set formulation=mixed
train "strain modes by polynomials, the default" cantilever_dynamic
solve "cpinn-solve: spectral elements"
solve "cpinn-solve --method modes" --method modes
