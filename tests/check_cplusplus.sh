#!/bin/sh
# Every installed header compiles by itself as C++ as well, of the oldest and of a recent standard.
#   check_cplusplus.sh COMPILER ROOT HEADER...     headers relative to ROOT
# Exit status 77, for skipped, without a compiler.
set -eu
compiler=$1
root=$2
shift 2
command -v "$compiler" >/dev/null || exit 77
bad=0
for header in "$@"; do
    for standard in c++11 c++20; do
        echo "#include \"$header\"" |
            "$compiler" -x c++ "-std=$standard" -Wall -Wextra -Wpedantic -Werror -fsyntax-only \
                -I"$root" - || bad=1
    done
done
exit $bad
