#!/bin/sh
# Installs what is missing, builds and runs every test. The last line counts the tests that were
# skipped because something that they need is not installed.
#   tools/test.sh [OPTIONS OF ctest...]
set -eu
cd "$(dirname "$0")/.."
tools/setup.sh
status=0
ctest --test-dir build --output-on-failure -j 3 --output-junit tests.xml "$@" || status=$?
skipped=$(sed -n 's/^[[:space:]]*<testcase name="\([^"]*\)".* status="notrun".*/\1/p' build/tests.xml | xargs)
echo "$(echo "$skipped" | wc -w) skipped${skipped:+: $skipped}"
exit $status
