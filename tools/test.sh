#!/bin/sh
# Installs what is missing, builds and runs every test.
#   tools/test.sh [OPTIONS OF ctest...]
set -eu
cd "$(dirname "$0")/.."
tools/setup.sh
ctest --test-dir build --output-on-failure -j 3 "$@"
