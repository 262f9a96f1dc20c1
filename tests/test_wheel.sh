#!/bin/bash
# The wheel in dist/, as a new user has it: in an environment of its own, without a compiler or any
# other program on PATH, and without the sources.
#   test_wheel.sh ROOT PYTHON
# Exit status 77, for skipped, without a wheel (tools/package/wheel.sh), with one that is older than the
# sources, or where Python makes no environments or pip finds no numpy.
set -eu
root=$1
python=$2
skip() {
    echo "wheel: $*"
    exit 77
}
wheels=("$root"/dist/cpinn-*.whl)
[ -f "${wheels[0]}" ] || skip "there is none in dist/"
newer=$(cd "$root" && find CMakeLists.txt pyproject.toml autodiff nn optim physics tools configs -type f \
    ! -name '*.pyc' -newer "${wheels[0]}")
[ -z "$newer" ] || skip "older than $(echo "$newer" | head -n 1)"
[ ${#wheels[@]} -eq 1 ] || { echo "wheel: several in dist/"; exit 1; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$python" -m venv "$work/venv" >"$work/log" 2>&1 || skip "no environment: $(cat "$work/log")"
"$work/venv/bin/pip" install --quiet numpy || skip "no numpy"
"$work/venv/bin/pip" install --quiet --no-index "${wheels[0]}"
version=$(sed -n 's/^project(cpinn VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")
cp "$root/tests/wheel.py" "$work"
cd "$work"
env -i PATH="$work/venv/bin" HOME="$work" TMPDIR="$work" "$work/venv/bin/python" wheel.py "$version"
