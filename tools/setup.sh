#!/usr/bin/env bash
# Make .venv and install the project into it.
#
#   bash tools/setup.sh        what users need: the package with its `all` extra
#   bash tools/setup.sh dev    what developers need: with every checking tool
#
# Safe to run again: it repairs and updates what is there. PYTHON=/path/to/python chooses another
# interpreter.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf '%s\n' "setup: $*" >&2; }
fail() { say "$*"; exit 1; }

mode=${1:-user}
case $mode in
    user) requirement=".[all]" ;;
    dev) requirement=".[dev]" ;;
    *) fail "usage: bash tools/setup.sh [dev]" ;;
esac

# -- system libraries ------------------------------------------------------------------------------

as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo -n "$@"; fi
}

can_be_root() {
    [ "$(id -u)" -eq 0 ] || { command -v sudo && sudo -n true; } >/dev/null 2>&1
}

is_installed() {
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

has_apt() { command -v apt-get && command -v dpkg-query; } >/dev/null

# Install packages if this may be done; show what apt-get says if it fails.
# apt's lists may be missing (fresh images) or old: they are refreshed once, before the first use.
apt_install() {
    local log status=1
    { has_apt && can_be_root; } || return 1
    log=$(mktemp)
    say "installing $* with apt-get"
    if { [ -n "${lists_are_fresh:-}" ] || as_root apt-get "${quietly[@]}" update; } >"$log" 2>&1 &&
        lists_are_fresh=yes &&
        as_root env DEBIAN_FRONTEND=noninteractive apt-get "${quietly[@]}" -y \
            --no-install-recommends install "$@" >>"$log" 2>&1; then
        status=0
    else
        cat "$log" >&2
    fi
    rm -f "$log"
    return $status
}
quietly=(-qq -o DPkg::Lock::Timeout=300)

# Install packages, or say what to install and go on: all but pictures and Open3D works without.
want() {
    local purpose=$1
    shift
    apt_install "$@" || {
        say "going on without $purpose; to have it:"
        say "    sudo apt-get install $*"
    }
}

if has_apt; then
    # Open3D loads the first three, off-screen rendering the next two, and neither wheel has them.
    wanted=(libusb-1.0-0 libgomp1 libx11-6 libegl1 libgl1)
    if [ -z "${PYTHON:-}" ] && ! python3 -c 'import ensurepip' 2>/dev/null; then
        wanted+=(python3 python3-venv)
    fi
    missing=()
    for package in "${wanted[@]}"; do
        is_installed "$package" || missing+=("$package")
    done
    if [ ${#missing[@]} -gt 0 ]; then
        want "system libraries for Open3D and for pictures" "${missing[@]}"
    fi
    if [ "$mode" = dev ] && ! command -v chromium chromium-browser google-chrome >/dev/null; then
        want "a browser, in which the tests open exported pages" chromium
    fi
    if [ "$mode" = dev ] && ! is_installed libpetsc-real-dev; then
        want "PETSc, for the plugin geodesic-toolkit-petsc" libpetsc-real-dev openmpi-bin
    fi
fi

# -- Python ----------------------------------------------------------------------------------------

is_recent() {
    "$1" -c 'import sys; raise SystemExit(sys.version_info < (3, 11))' >/dev/null 2>&1
}

choose_python() {
    local candidate
    for candidate in ${PYTHON:-python3 python3.12 python3.11 python3.13 python3.14}; do
        if is_recent "$candidate"; then
            printf '%s\n' "$candidate"
            return
        fi
    done
    return 1
}

python=.venv/bin/python
if [ -n "${PYTHON:-}" ] || ! is_recent "$python"; then
    chosen=$(choose_python) || fail "Python 3.11 or newer is needed (found: ${PYTHON:-$(
        python3 --version 2>&1 || echo none
    )}). Install one, or name it: PYTHON=/path/to/python bash tools/setup.sh"
    "$chosen" -m venv --clear .venv || fail "$chosen cannot make a virtual environment; on Debian
and Ubuntu: sudo apt-get install python3-venv"
fi

# -- a compiler ------------------------------------------------------------------------------------

# The kernels are in C++. CMake and Ninja come from PyPI where they are missing; these two do not.
compiles() {
    printf '#include <bit>\n#include <span>\nstd::span<int> numbers;\n' |
        ${CXX:-c++} -std=c++20 -x c++ -fsyntax-only - >/dev/null 2>&1  # CXX may be several words
}

has_headers() {
    "$python" -c 'import pathlib, sysconfig
raise SystemExit(not pathlib.Path(sysconfig.get_path("include"), "Python.h").is_file())'
}

how_to_pip_install() {
    if has_apt; then
        printf 'sudo apt-get install %s' "$1"
    elif [ "$(uname)" = Darwin ]; then
        printf 'xcode-select --install'
    elif command -v dnf >/dev/null; then
        printf 'sudo dnf install %s' "$2"
    else
        printf '%s of your system' "$2"
    fi
}

compiles || { apt_install g++ && compiles; } ||
    fail "a compiler for C++20 is needed (GCC 11, Clang 14, or newer): $(how_to_install g++ gcc-c++)"
headers=python$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')-dev
has_headers || { apt_install "$headers" && has_headers; } ||
    fail "the header files of Python are needed: $(how_to_install "$headers" python3-devel)"

# -- the project -----------------------------------------------------------------------------------

# uv installs in a fraction of the time that pip takes; where it is not available, pip does the same.
uv=$(command -v uv || true)
if [ -z "$uv" ]; then
    "$python" -m pip install -qq --disable-pip-version-check uv && uv=.venv/bin/uv ||
        say "uv is not available; pip takes a little longer"
fi
# Editable, so that Python finds the kernels in this folder, too; and they are built for this
# processor only, which takes a third of the time.
pip_install() {
    if [ -n "$uv" ]; then
        "$uv" pip install --quiet --python "$python" "$@"
    else
        "$python" -m pip install -qq --disable-pip-version-check "$@"
    fi
}

plugins=(--editable ./plugins/geodesic-toolkit-study)
if [ "$mode" = dev ]; then
    for name in polygon volume knn amg cholmod petsc; do
        plugins+=(--editable "./plugins/geodesic-toolkit-$name")
    done
fi
say "installing geodesic-toolkit ($requirement) into .venv"
pip_install --editable "$requirement" "${plugins[@]}"

# CHOLMOD, which one of the plugins calls, has no wheels: scikit-sparse is built in about a minute.
install_cholmod() {
    is_installed libsuitesparse-dev || apt_install libsuitesparse-dev || return 1
    "$python" -c 'import sksparse.cholmod' 2>/dev/null ||
        pip_install --editable "./plugins/geodesic-toolkit-cholmod[cholmod]"
}
if [ "$mode" = dev ] && ! { has_apt && install_cholmod; }; then
    say "going on without CHOLMOD: the tests of its plugin are skipped; to have it:"
    say "    sudo apt-get install libsuitesparse-dev"
    say "    .venv/bin/python -m pip install './plugins/geodesic-toolkit-cholmod[cholmod]'"
fi

# petsc4py, for another of the plugins, has no wheels either: it is built in half a minute.
if [ "$mode" = dev ] && ! { bash tools/petsc.sh "$python" &&
    pip_install --no-deps build/petsc/*.whl; }; then
    say "going on without PETSc: most tests of its plugin are skipped; to have it:"
    say "    sudo apt-get install libpetsc-real-dev openmpi-bin"
    say "    bash tools/petsc.sh $python && $python -m pip install build/petsc/*.whl"
fi
say "done: $("$python" --version), .venv/bin/geodesic-toolkit"
