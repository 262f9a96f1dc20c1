#!/bin/sh
# One harness on a copy of its corpus: run.sh PROGRAM SECONDS [CORPUS]. For hours, all of them:
#   cmake -S . -B build-fuzz -G Ninja -DCMAKE_C_COMPILER=clang -DCPINN_SANITIZE=ON -DCPINN_FUZZ=ON
#   for i in build-fuzz/tests/fuzz/fuzz_*; do tests/fuzz/run.sh $i 7200; done
# What it finds stays beside the program, as NAME-crash-..., NAME-timeout-... or NAME-oom-....
set -eu
name=$(basename "$1")
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d "${TMPDIR:-/tmp}/cpinn_fuzz_XXXXXX")
trap 'rm -rf "$work"' EXIT
mkdir "$work/found" "$work/seeds"
corpus=${3:-$here/corpus/${name#fuzz_}}
if [ "$name" = fuzz_yaml ]; then # and the scenes of the project
    cp "$here"/../../configs/*.yaml "$here"/../../configs/*/*.yaml "$work/seeds"
fi
if [ "$name" = fuzz_equations ]; then
    cp "$here"/../../configs/equations/*.yaml "$work/seeds"
fi
if [ "$name" = fuzz_npz ]; then # and tables
    cp "$here"/corpus/csv/* "$work/seeds"
fi
if [ -d "$corpus" ]; then
    cp "$corpus"/* "$work/seeds"
fi
# HDF5 keeps memory of its own when it refuses some files, and of some asks for far more than there
# is before it finds that they are not as long; it is what is used that counts, -rss_limit_mb.
limits=
case $name in
*table | *checkpoint)
    export ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1:max_allocation_size_mb=2000
    limits=-malloc_limit_mb=2000
    ;;
esac
"$1" $limits -max_total_time="$2" -timeout=5 -rss_limit_mb=1024 -max_len=16384 \
    -artifact_prefix="$1-" -verbosity=0 "$work/found" "$work/seeds"
