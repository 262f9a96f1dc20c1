#!/bin/sh
# The version of the project stands in CMakeLists.txt. What says it besides says the same.
#   test_version.sh BIN ROOT VERSION
set -eu
bin=$1
root=$2
version=$3

fail() {
    echo "version: $*" >&2
    exit 1
}

[ "$("$bin/cpinn-train" --version)" = "cpinn-train $version" ] ||
    fail "cpinn-train --version says $("$bin/cpinn-train" --version)"
grep -qx "version: $version" "$root/CITATION.cff" || fail "CITATION.cff: version is not $version"
date=$(sed -n 's/^date-released: //p' "$root/CITATION.cff")
released=$(grep -m 1 '^## \[[0-9]' "$root/CHANGELOG.md")
[ "$released" = "## [$version] - $date" ] ||
    fail "CHANGELOG.md: the first release is '$released', not '## [$version] - $date'"
# The last row of the table of formats is the one that this version writes.
format=$(sed -n 's/^#define CHECKPOINT_FORMAT_VERSION //p' "$root/tools/files/checkpoint.h")
since=$(sed -n 's/^#define CHECKPOINT_FORMAT_SINCE  *"\([^"]*\)".*/\1/p' "$root/tools/files/checkpoint.h")
grep '^| [0-9]' "$root/CHANGELOG.md" | tail -n 1 | grep -q "^| $format | $since" ||
    fail "CHANGELOG.md: the last format of checkpoints is not $format, since $since"
