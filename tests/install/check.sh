#!/bin/sh
# Installs a build into a temporary prefix, moves the prefix, and builds and runs a program against
# it: with the CMake package and with pkg-config. From the environment: CMAKE, CC, CFLAGS,
# GENERATOR and LIBDIR of the build.
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

# Nothing may point back into the sources or to where the files first were.
"$CMAKE" --install "$build" --prefix "$work/first" >"$work/log" || fail "$(cat "$work/log")"
mv "$work/first" "$work/prefix"
for text in "$root/" "$build/" "$work/first"; do
    found=$(grep -rlIF "$text" "$work/prefix" || true)
    [ -z "$found" ] || fail "$text is named in $found"
done
for path in include/cpinn/autodiff/ad.h include/cpinn/nn/nn.h include/cpinn/optim/optim.h \
    include/cpinn/physics/scene.h share/cpinn/configs/elastica.yaml; do
    [ -f "$work/prefix/$path" ] || fail "$path was not installed"
done
for program in "$build"/tools/cpinn-*; do
    [ -f "$program" ] && [ -x "$program" ] || continue
    name=${program##*/}
    "$work/prefix/bin/$name" --help >"$work/log" 2>&1 || fail "$name --help: $(cat "$work/log")"
done

"$CMAKE" -S "$root/tests/install" -B "$work/cmake" -G "$GENERATOR" -DCMAKE_C_COMPILER="$CC" \
    -DCMAKE_PREFIX_PATH="$work/prefix" >"$work/log" 2>&1 || fail "$(cat "$work/log")"
"$CMAKE" --build "$work/cmake" >"$work/log" 2>&1 || fail "$(cat "$work/log")"
"$work/cmake/outside" || fail "the program built with CMake failed"

export PKG_CONFIG_PATH="$work/prefix/$LIBDIR/pkgconfig"
# shellcheck disable=SC2046,SC2086  # lists of options
"$CC" -std=c11 $CFLAGS $(pkg-config --cflags cpinn) "$root/tests/install/outside.c" \
    -o "$work/outside" $(pkg-config --libs cpinn)
"$work/outside" || fail "the program built with pkg-config failed"
