#!/bin/sh
# Installs a build into a temporary prefix, moves the prefix, and builds and runs programs against
# it: with the CMake package, with pkg-config, from C++ and from Python. From the environment: CMAKE,
# CC, CFLAGS, GENERATOR and LIBDIR of the build.
#   check.sh ROOT BUILD
set -eu
root=$1
build=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() {
    echo "install: $*" >&2
    exit 1
}

# Nothing may point back into the sources or to where the files first were. What stands before such
# a path is no part of a path: a tree in /cpinn is not meant by include/cpinn/ or ~/cpinn/.
"$CMAKE" --install "$build" --prefix "$work/first" >"$work/log" || fail "$(cat "$work/log")"
mv "$work/first" "$work/prefix"
for text in "$root/" "$build/" "$work/first"; do
    pattern=$(printf '%s' "$text" | sed 's/[][\.^$*+?(){}|]/\\&/g')
    found=$(grep -rlIE "(^|[^[:alnum:]_.}~/-])$pattern" "$work/prefix" || true)
    [ -z "$found" ] || fail "$text is named in $found"
done
for path in include/cpinn/cpinn.h include/cpinn/autodiff/ad.h include/cpinn/physics/scene/scene.h \
    include/cpinn/tools/train/train_settings.h include/cpinn/physics/chain/reduced.h "$LIBDIR/libcpinn.so" share/cpinn/configs/elastica.yaml \
    share/man/man1/cpinn-train.1 share/doc/cpinn/README.md; do
    [ -f "$work/prefix/$path" ] || fail "$path was not installed"
done

# The shared library offers every function that an installed header declares.
if "$CC" --version | grep -q 'Free Software'; then
    (cd "$work/prefix/include/cpinn" && find . -name '*.h') | sed 's/.*/#include "&"/' >"$work/all.c"
    "$CC" -std=c11 -I"$work/prefix/include/cpinn" -aux-info "$work/declared" -fsyntax-only \
        "$work/all.c" || fail "the installed headers do not compile"
    nm -D --defined-only "$work/prefix/$LIBDIR/libcpinn.so" | sed 's/.* //; s/@.*//' >"$work/offered"
    grep "$work/prefix.* extern " "$work/declared" | sed 's/.* extern //; s/ (.*//; s/.*[ *]//' |
        sort -u >"$work/names"
    [ "$(wc -l <"$work/names")" -gt 100 ] || fail "the installed headers declare hardly a function"
    missing=$(grep -vxFf "$work/offered" "$work/names" || true)
    [ -z "$missing" ] || fail "the library does not offer" $missing
fi
for program in "$build"/tools/cpinn-*; do
    [ -f "$program" ] && [ -x "$program" ] || continue
    name=${program##*/}
    "$work/prefix/bin/$name" --help >"$work/log" 2>&1 || fail "$name --help: $(cat "$work/log")"
done

"$CMAKE" -S "$root/tests/install" -B "$work/cmake" -G "$GENERATOR" -DCMAKE_C_COMPILER="$CC" \
    -DCMAKE_C_FLAGS="$CFLAGS" -DCMAKE_CXX_FLAGS="$CFLAGS" -DCMAKE_PREFIX_PATH="$work/prefix" \
    >"$work/log" 2>&1 || fail "$(cat "$work/log")"
"$CMAKE" --build "$work/cmake" >"$work/log" 2>&1 || fail "$(cat "$work/log")"
scene=$work/prefix/share/cpinn/configs/cantilever_dynamic.yaml
"$work/cmake/outside" || fail "the program built with CMake failed"
"$work/cmake/by_hand" || fail "the scene filled in by hand: status $?"
"$work/cmake/own_physics" || fail "physics of one's own: status $?"
"$work/cmake/from_file" "$scene" "$work/run" || fail "the scene file: status $?"
if [ -x "$work/cmake/from_file_cpp" ]; then
    "$work/cmake/from_file_cpp" "$scene" "$work/run_cpp" || fail "the scene file from C++: status $?"
fi
if "$work/cmake/from_file" "$scene" "$work/run" 2>"$work/log"; then
    fail "a run was written over"
fi
grep -q 'there is a run already' "$work/log" || fail "$(cat "$work/log")"

export PKG_CONFIG_PATH="$work/prefix/$LIBDIR/pkgconfig"
export LD_LIBRARY_PATH="$work/prefix/$LIBDIR"
for package in cpinn cpinn-static; do
    # shellcheck disable=SC2046,SC2086  # lists of options
    "$CC" -std=c11 $CFLAGS $(pkg-config --cflags $package) "$root/tests/install/outside.c" \
        -o "$work/outside" $(pkg-config --libs $package) -lm || fail "$package cannot be linked"
    "$work/outside" || fail "the program built with pkg-config and $package failed"
done

# Python cannot load what is built with the sanitizers.
if [ -z "$CFLAGS" ] && python3 -c 'import numpy' 2>/dev/null; then
    PYTHONPATH=$work/prefix/lib/python3/dist-packages LD_LIBRARY_PATH='' \
        python3 "$root/tests/install/from_file.py" "$scene" || fail "the scene file from Python"
fi
