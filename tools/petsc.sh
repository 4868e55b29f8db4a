#!/usr/bin/env bash
# Build petsc4py against the PETSc of the system, as a wheel in build/petsc:
#
#   bash tools/petsc.sh .venv/bin/python
#
# PETSC_DIR=/path/to/petsc names a PETSc; without it, that of Debian and Ubuntu is taken.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '%s\n' "petsc: $*" >&2; }

python=$1
if [ -z "${PETSC_DIR:-}" ]; then
    for folder in /usr/lib/petscdir/petsc[0-9]*/*-real; do
        [ -f "$folder/include/petsc.h" ] && PETSC_DIR=$folder
    done
fi
[ -n "${PETSC_DIR:-}" ] || { say "there is no PETSc: apt-get install libpetsc-real-dev"; exit 1; }
export PETSC_DIR

number() {
    sed -n "s/^#define PETSC_VERSION_$1 *\([0-9]*\).*/\1/p" "$PETSC_DIR/include/petscversion.h"
}
release=$(number MAJOR).$(number MINOR)

# The wheel must be of this Python and of this PETSc.
tag=$("$python" -c 'import sys; print("cp%d%d" % sys.version_info[:2])')
if compgen -G "build/petsc/petsc4py-$release.*-$tag-*.whl" >/dev/null; then exit 0; fi

say "building petsc4py $release against $PETSC_DIR"
rm -rf build/petsc
mkdir -p build/petsc
"$python" -m venv build/petsc/tools
# petsc4py before 3.20 is written for Cython 0.29, and uses what setuptools 74 removed.
tools=(setuptools wheel numpy cython)
case $release in 3.1[0-9]) tools=("setuptools<74" wheel numpy "cython<3") ;; esac
build/petsc/tools/bin/pip install -qq --disable-pip-version-check "${tools[@]}"
# Without optimisation, which takes most of two minutes and speeds nothing up: PETSc does the work.
CFLAGS="-O0 -g0 -w" build/petsc/tools/bin/pip wheel -qq --disable-pip-version-check --no-deps \
    --no-build-isolation --wheel-dir build/petsc "petsc4py==$release.*"
rm -rf build/petsc/tools
