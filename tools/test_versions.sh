#!/usr/bin/env bash
# Run tests with other versions than those in .venv, in an environment and a copy of the sources of their own.
# Usage: tools/test_versions.sh newest [pytest options]  newest interpreter here, newest dependencies
#        tools/test_versions.sh oldest [pytest options]  Python 3.11, oldest dependencies that pyproject.toml allows
# PYTHON=/path/to/python chooses the interpreter. Exit status: that of pytest; 69 if there is no interpreter.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf 'test-%s: %s\n' "$which" "$*" >&2; }
no_interpreter=69

# Print the version, if the interpreter can build and hold the package: 3.11 or newer, C headers, venv.
usable_version() {
  "$1" -c 'import ensurepip, os, sys, sysconfig, venv
has_headers = os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h"))
usable = sys.version_info >= (3, 11) and sys.version_info.releaselevel == "final" and has_headers
print("%d.%d.%d" % sys.version_info[:3] if usable else sys.exit(1))' 2>/dev/null
}

# Print version and path of every usable interpreter: those in PATH, Debian's, pyenv's.
interpreters() {
  local candidate version
  for candidate in $(compgen -c python3 | grep -xE 'python3(\.[0-9]+)?' | sort -u) /usr/bin/python3.[0-9]* \
    "${PYENV_ROOT:-$HOME/.pyenv}"/versions/*/bin/python3; do
    if version=$(usable_version "$candidate"); then printf '%s %s\n' "$version" "$candidate"; fi
  done | sort -uV
}

which=${1:-}
case $which in
  newest) wanted='.' ;;
  oldest) wanted='^3\.11\.' ;;
  *) echo "usage: tools/test_versions.sh newest|oldest [pytest options]" >&2; exit 2 ;;
esac
shift
if [ $# = 0 ]; then set -- -m 'not slow'; fi
python=${PYTHON:-$(interpreters | { grep "$wanted" || true; } | tail -n 1 | cut -d ' ' -f 2)}
if [ -z "$python" ]; then
  say "no interpreter here that fits (with its C headers and venv). Install one, or name it: make test-$which PYTHON=/path/to/python"
  exit $no_interpreter
fi
say "$("$python" -V) of $("$python" -c 'import sys; print(sys.base_prefix)')"

project=build/$which/project
rm -rf "build/$which"
tools/copy_sources.sh "$project"
if [ "$which" = oldest ]; then
  "$python" tools/lower_bounds.py >"build/$which/constraints.txt"
  export PIP_CONSTRAINT=$PWD/build/$which/constraints.txt
fi
PYTHON=$python "$project/tools/setup.sh"
cd "$project"
versions='import importlib.metadata as m; print(*(f"{n} {m.version(n)}" for n in ("numpy", "scipy", "cython", "h5py", "matplotlib")), sep=", ")'
say "$(.venv/bin/python -c "$versions")"
.venv/bin/python -m pytest "$@"
