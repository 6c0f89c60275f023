#!/usr/bin/env bash
# Install everything missing to build and run ancfsparse: system packages (apt), .venv, the package itself.
# Usage: tools/setup.sh           PYTHON=python3.12 tools/setup.sh chooses another interpreter
#        tools/setup.sh peers     the other codes of the benchmarks too
#        tools/setup.sh all-sets  compiled for every instruction set that this machine runs; otherwise for the widest alone
#        tools/setup.sh develop   so that importing the package compiles changed files
#        tools/setup.sh plain     no longer so
#        tools/setup.sh check     install nothing; fail if compiled modules are older than their sources
# The wheel that it installs is kept in build/. ANCFSPARSE_WHEEL=FILE installs that one without compiling.
# An option given once stays in force. Where nothing has changed, nothing is done. One process sets up, others wait.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

venv=.venv
log=$venv/setup.log
lock=build/.lock
linked=ancfsparse/compiled # see `link_compiled`

say() { printf 'setup: %s\n' "$*" >&2; }
stop() { say "$*"; exit 1; }

# ---- options, and the present state -----------------------------------------------------------

# Print a digest of the sources, or of those alone that are compiled.
digest() {
  find ancfsparse codegen generated vendored meson.build meson.options pyproject.toml -type f \
    ! -path '*/__pycache__/*' "$@" -print0 | LC_ALL=C sort -z | xargs -0 sha256sum | sha256sum | cut -c -64
}
digest_of_all() { digest; }
digest_of_compiled() { digest ! -name '*.py' ! -name pyproject.toml; }

has() { [ -e "$venv/.$1" ]; }

target=${1:-}
case $target in
  '' | peers | all-sets | develop | plain) ;;
  check)
    # An editable install compiles on import.
    has develop || [ "$(digest_of_compiled)" = "$(cut -d ' ' -f 2 "$venv/.package" 2>/dev/null)" ] ||
      stop "compiled modules are older than their sources: run make setup, or make develop once to have imports compile what has changed."
    exit ;;
  *) stop "unknown argument $target; the head of tools/setup.sh lists those there are." ;;
esac

mkdir -p build
exec 9>"$lock"
if ! flock --nonblock 9; then
  say "waiting for another process that sets up here"
  flock 9
fi
export ANCFSPARSE_HAS_LOCK=1 # for tools/ninja_in_turn.sh, which pip starts below

if [ "$target" = peers ] || has peers; then extras=dev,peers; else extras=dev; fi
if [ "$target" = all-sets ] || has all-sets; then sets=runnable; else sets=native; fi
if [ "$target" != plain ] && { [ "$target" = develop ] || has develop; }; then mode=develop; else mode=plain; fi
requirements="$(cat pyproject.toml tools/setup.sh | sha256sum | cut -c -64) $extras"
if [ $mode = develop ]; then # Python finds the sources themselves
  package="$(sha256sum <meson.build | cut -c -64) - $sets develop"
else
  package="$(digest_of_all) $(digest_of_compiled) $sets plain"
fi
is_there() { [ "$(cat "$venv/.$1" 2>/dev/null)" = "$2" ]; }
if is_there requirements "$requirements" && is_there package "$package" && "$venv/bin/python" -c pass 2>/dev/null; then
  exit
fi

packages=(libsuitesparse-dev libopenblas-dev) # without OpenBLAS, CHOLMOD runs on reference BLAS
if [ $extras = dev,peers ]; then packages+=(libsundials-dev libgl1); fi # Exudyn loads libGL

# ---- the interpreter ----------------------------------------------------------------------------

find_python() {
  local candidate
  for candidate in "${PYTHON:-python3}" python3.11 python3.12 python3.13 python3.14; do
    if "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
      python=$candidate
      return
    fi
    if [ -n "${PYTHON:-}" ]; then return; fi # named by the user: take no other
  done
}

stop_without_python() {
  local found
  found=$("${PYTHON:-python3}" -V 2>/dev/null) || found="not there"
  stop "needs Python 3.11 or newer; ${PYTHON:-python3} is $found. Name another: make setup PYTHON=/path/to/python3.11"
}

# ---- system packages ----------------------------------------------------------------------------

missing_packages() {
  local package
  for package in "${packages[@]}"; do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || echo "$package"
  done
  command -v cc >/dev/null || echo build-essential
  command -v make >/dev/null || echo make
  if [ -z "$python" ]; then
    echo python3 python3-dev python3-venv
  elif [ "$("$python" -c 'import sys; print(sys.base_prefix)')" = /usr ]; then # Debian's own
    local name
    name=$("$python" -c 'import sys; print("python%d.%d" % sys.version_info[:2])')
    "$python" -c 'import ensurepip, venv' 2>/dev/null || echo "$name-venv"
    has_headers || echo "$name-dev"
  fi
}

has_headers() {
  "$python" -c 'import os, sys, sysconfig
sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))'
}

install_packages() {
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null ||
      stop "needs the system packages $*, and may not install them: neither root nor sudo. Ask an administrator for 'apt-get install $*'."
    if [ -t 0 ]; then as_root=(sudo); else as_root=(sudo -n); fi
  fi
  say "installing the system packages $*"
  { "${as_root[@]}" apt-get update -qq &&
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >/dev/null; } ||
    stop "could not install the system packages $* with apt-get (its message stands above). Install them, then run this again."
}

python=
find_python
[ -n "$python" ] || [ -z "${PYTHON:-}" ] || stop_without_python
if command -v dpkg-query >/dev/null && command -v apt-get >/dev/null; then
  missing=$(missing_packages | tr '\n' ' ')
  if [ -n "$missing" ]; then
    # shellcheck disable=SC2086
    install_packages $missing
    find_python
  fi
else
  say "no apt on this system: SuiteSparse (with headers), OpenBLAS, a C compiler and Python headers must be present."
fi
[ -n "$python" ] || stop_without_python
"$python" -c 'import ensurepip, venv' 2>/dev/null ||
  stop "$python cannot make virtual environments (modules venv and ensurepip). Name another: make setup PYTHON=/path/to/python3.11"
has_headers ||
  stop "$python comes without its C headers (Python.h). Install them, or name another: make setup PYTHON=/path/to/python3.11"

# ---- the environment ----------------------------------------------------------------------------

if ! "$venv/bin/python" -c pass 2>/dev/null; then
  say "making $venv with $("$python" -V)"
  rm -rf "$venv"
  "$python" -m venv "$venv"
fi
export PATH="$PWD/$venv/bin:$PATH"
: >"$log"

# pip warns of every package that a local index lacks: its output goes to the log, and to the terminal
# where it fails. Options are those of pip 23.0, which Debian 12 has: no -C for --config-settings.
pip() {
  "$venv/bin/python" -m pip --disable-pip-version-check --no-input "$@" >>"$log" 2>&1 && return
  grep -v '^WARNING: Location .* is ignored' "$log" | tail -n 30 >&2 || true
  stop "could not $step. The end of $PWD/$log stands above: mend its cause, then run the same make command again."
}
begin() {
  step=$1
  say "$step ($2)"
}

# The package is built without isolation, in a folder that stays, so that what has not changed is not
# compiled again; its requirements and scikit-sparse, which is built from source, come first.
if ! is_there requirements "$requirements"; then
  rm -f "$venv/.requirements" "$venv/.package"
  begin "install what ancfsparse requires" "about a minute the first time: scikit-sparse is compiled"
  "$venv/bin/python" - pyproject.toml >"$venv/requirements.txt" <<'PYTHON'
import sys, tomllib
with open(sys.argv[1], "rb") as file:
    project = tomllib.load(file)
cholmod = project["project"]["optional-dependencies"]["cholmod"]
print(*project["build-system"]["requires"], *project["project"]["dependencies"], *cholmod, sep="\n")
PYTHON
  pip install -r "$venv/requirements.txt"
fi

# Python that is started here finds the sources before the installed package: it needs the compiled modules.
link_compiled() {
  local target
  target=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("platlib"))')/ancfsparse/compiled
  ln -sfn "$(realpath --relative-to=ancfsparse "$target")" $linked
}

build=build/$("$venv/bin/python" -c 'import sys; print("cp%d%d" % sys.version_info[:2])')
# Meson does not take a value that an earlier meson.options did not have.
if [ meson.options -nt "$build/build.ninja" ]; then rm -rf "$build"; fi
options=(--no-build-isolation "--config-settings=setup-args=-Dinstruction_sets=$sets"
  "--config-settings=builddir=$build")
rm -f "$venv/.package"
wheel=${ANCFSPARSE_WHEEL:-}
if [ -n "$wheel" ]; then
  begin "install $wheel" "seconds"
elif [ $sets = runnable ]; then
  begin "build ancfsparse for all instruction sets of this machine" "up to six minutes the first time, then changed files only"
else
  begin "build ancfsparse for this machine" "two or three minutes the first time, then changed files only"
fi
find ancfsparse codegen -name __pycache__ -prune -exec rm -rf {} + || true # another process may write there
if [ $mode = develop ]; then
  rm -f $linked
  NINJA=$PWD/tools/ninja_in_turn.sh pip install "${options[@]}" -e ".[$extras]"
else
  if [ -z "$wheel" ]; then
    rm -f build/ancfsparse-*.whl
    pip wheel --no-deps "${options[@]}" --wheel-dir build .
    wheel=$(echo build/ancfsparse-*.whl)
  fi
  is_there requirements "$requirements" || pip install "$wheel[$extras]"
  pip install --no-deps --force-reinstall "$wheel"
  link_compiled
fi

if [ "$extras" != "${extras#*peers}" ]; then
  begin "build the SUNDIALS module of the benchmarks" "seconds"
  "$venv/bin/python" tools/build_sundials.py
fi

echo "$requirements" >"$venv/.requirements"
echo "$package" >"$venv/.package"
for each in peers all-sets develop; do if [ "$target" = $each ]; then touch "$venv/.$each"; fi; done
if [ "$target" = plain ]; then rm -f "$venv/.develop"; fi
say "done"
