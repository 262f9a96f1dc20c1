#!/bin/sh
# Installs what is missing and builds cpinn into build/. Further Debian packages may be named.
#   tools/setup.sh [PACKAGE...]
set -eu
cd "$(dirname "$0")/.."

needed="gcc libc6-dev cmake ninja-build pkg-config libopenblas-dev libhdf5-dev libyaml-dev \
libsundials-dev coinor-libipopt-dev zlib1g-dev libembree-dev libompl-dev g++ libcmocka-dev gnuplot-nox python3-numpy $*"

installed() {
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

as_root() {
    if [ "$(id -u)" -eq 0 ]; then
        "$@"
    elif command -v sudo >/dev/null; then
        sudo "$@"
    else
        echo "setup: installing needs root or sudo; as root: apt-get install$missing" >&2
        exit 1
    fi
}

if command -v dpkg-query >/dev/null && command -v apt-get >/dev/null; then
    missing=
    for package in $needed; do
        installed "$package" || missing="$missing $package"
    done
    if [ -n "$missing" ]; then
        echo "setup: installing$missing"
        as_root apt-get update -qq
        # shellcheck disable=SC2086  # a list of names
        as_root env DEBIAN_FRONTEND=noninteractive \
            apt-get install -y -qq --no-install-recommends -o Dpkg::Use-Pty=0 $missing
    fi
else
    echo "setup: not a Debian system; make sure of the equivalents of: $needed" >&2
fi

echo "setup: building into build/"
if [ ! -f build/CMakeCache.txt ]; then
    cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=Release
fi
cmake --build build
