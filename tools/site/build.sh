#!/bin/sh
# Builds the site of the project into build/site/html; begin with index.html there. Needs the built
# programs (tools/setup.sh), python3-venv and doxygen, and PyPI for what requirements.txt names. Any warning,
# such as a link that leads nowhere, is an error.
#   tools/site/build.sh
set -eu
cd "$(dirname "$0")/../.."
tools/setup.sh python3-venv doxygen
out=build/site
mkdir -p $out
if ! cmp -s tools/site/requirements.txt $out/env/requirements.txt; then
    python3 -m venv --clear $out/env
    $out/env/bin/pip install --quiet --disable-pip-version-check -r tools/site/requirements.txt
    cp tools/site/requirements.txt $out/env
fi
rm -rf $out/docs $out/installed
$out/env/bin/python tools/site/collect.py build/tools $out/docs
cmake --install build --prefix $out/installed >$out/installed.txt
doxygen tools/site/Doxyfile
NO_MKDOCS_2_WARNING=1 $out/env/bin/mkdocs build --quiet --strict --clean --config-file $out/mkdocs.yml
echo "site: $PWD/$out/html/index.html"
