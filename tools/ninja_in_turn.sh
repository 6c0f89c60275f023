#!/usr/bin/env bash
# Run ninja while no other process builds here. After `make develop`, importing the package runs this.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
ninja=$root/.venv/bin/ninja

# meson-python sends the output of its commands into a log: a user sees what its parent writes.
say() { printf 'ancfsparse: %s\n' "$*" >"/proc/$PPID/fd/2" || true; }

if [ -z "${ANCFSPARSE_HAS_LOCK:-}" ]; then # not started by tools/setup.sh, which has it
  exec 9>"$root/build/.lock"
  if ! flock --nonblock 9; then
    say "waiting for another process that builds in $root"
    flock 9
  fi
  case $("$ninja" -n "$@") in
    *'no work to do'*) ;;
    *) say "compiling changed files in $root" ;;
  esac
fi
exec "$ninja" "$@"
