#!/usr/bin/env bash
# Set this repository up in a bare Debian 12, see tools/bare_debian.sh, and run its examples there.
# Usage: tools/test_fresh.sh            the set-up commands of README.md, then its examples
#        tools/test_fresh.sh COMMAND    another command, then the examples
# Exit status: 69 where it cannot run.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if [ $# -gt 0 ]; then
  commands=("$@")
else
  mapfile -t commands < <(sed -n '/^```sh$/,/^```$/s/^\(make [a-z-]*\).*/\1/p' README.md)
  [ "${#commands[@]}" -gt 0 ] || { echo "test-fresh: README.md names no set-up command" >&2; exit 1; }
fi

root=$(mktemp -d)
trap 'tools/bare_debian.sh remove "$root"' EXIT
tools/bare_debian.sh make "$root"
for command in "${commands[@]}" '.venv/bin/python tools/run_readme.py'; do
  tools/bare_debian.sh run "$root" "$command"
done
