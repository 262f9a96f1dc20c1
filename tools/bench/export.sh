#!/bin/bash
# How long an exported model takes, beside cpinn's own evaluation of it: cpinn-export, then the C by
# each compiler. Microseconds per point on one thread.
#   tools/bench/export.sh [FILE.csv]     from the root of the project, which is built
set -u
cd "$(dirname "$0")/../.." || exit 2
PATH=$PWD/build/tools:$PWD/build/tools/bench:$PATH
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
compilers=('gcc -O2' 'gcc -O3 -march=native' 'clang -O2' 'clang -O3 -march=native')
file=${1:-$work/table.csv}
echo 'scene,columns,by,value,value_in_batches,with_jacobian,with_jacobian_in_batches' >"$file" || exit 2

# exported NAME COLUMNS NUMBER: rows of a run by every compiler.
exported() {
    local options=() compiler
    [ -z "$2" ] || options+=(--columns "$2")
    [ "$3" = double ] || options+=(--single)
    cpinn-export "$work/$1" --c "$work/model" --force "${options[@]}" >/dev/null || exit 1
    for compiler in "${compilers[@]}"; do
        command -v "${compiler%% *}" >/dev/null || continue
        $compiler -std=c99 -D_POSIX_C_SOURCE=200809L -DHEADER='"model.h"' -DNAME=model \
            -DNUMBER="$3" -I"$work" -o "$work/time" tools/bench/export_time.c "$work/model.c" -lm || exit 1
        echo "$1,${2:-all},$compiler $3,$("$work/time" | tr ' ' ,)" >>"$file"
    done
}

# measured NAME CONFIG COLUMNS OVERRIDES...: cpinn's own evaluation, and the C.
measured() {
    local name=$1 config=$2 columns=$3
    shift 3
    [ -d "$work/$name" ] || cpinn-train "configs/$config.yaml" --out "$work/$name" --quiet "$@" 2>/dev/null
    echo "$name,${columns:-all},cpinn,$(evaluate "$work/$name" "$columns" | tr ' ' ,)" >>"$file"
    exported "$name" "$columns" double
    exported "$name" "$columns" float
}

measured elastica elastica ''
measured cantilever_dynamic cantilever_dynamic ''
measured cantilever_dynamic cantilever_dynamic 'r q'
measured deep_64_64 cantilever_deep 'r q' --set 'network.hidden=[64, 64]' \
    --set 'training.stages=[{optimizer: adam, steps: 30}]'

# family NAME CONFIG OVERRIDES...: a family in the strain form, us a member: shape of the network alone,
# with its error, with one step and its error, tip with one step, its derivatives.
family() {
    local name=$1 config=$2 compiler options number
    shift 2
    cpinn-train "configs/$config.yaml" --out "$work/$name" --quiet "$@" 2>/dev/null
    for options in '' '--columns r' --single '--single --columns r'; do
        cpinn-export "$work/$name" --c "$work/model" --force $options >/dev/null || exit 1
        number=double
        [[ $options != *--single* ]] || number=float
        for compiler in "${compilers[@]}"; do
            command -v "${compiler%% *}" >/dev/null || continue
            $compiler -std=c99 -D_POSIX_C_SOURCE=200809L -DHEADER='"model.h"' -DNAME=model -DNUMBER=$number \
                -I"$work" -o "$work/time" tools/bench/export_family_time.c "$work/model.c" -lm || exit 1
            echo "$name: ${options:-all} $compiler: $("$work/time")"
        done
    done
}

awk -F, '{ printf "%-19s %-8s %-31s %8s %17s %14s %s\n", $1, $2, $3, $4, $5, $6, $7 }' "$file"
echo 'a member of a family, 21 points: shape, shape and error, one step and error, tip, derivatives'
family tendon_family robots/tendon_family --set members.solved=4096 --set 'network.hidden=[64, 64]' \
    --set 'training.stages=[{optimizer: adam, steps: 100}]'
