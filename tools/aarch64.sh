#!/usr/bin/env bash
# Build the wheel for 64-bit ARM on another machine, in build/aarch64, and run it there by emulation: positions of a
# pendulum and of a chain are compared with those of this machine, and fast tests run (arguments name others).
# Debian's cross compiler and emulator are installed; Python for ARM and the requirements are unpacked in that folder.
# Four minutes of compilation on two cores the first time, then changed files only; the tests are slow, as emulated.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
root=$PWD
folder=$root/build/aarch64
system=$folder/system
site=$folder/site
python=$root/.venv/bin/python
say() { printf 'aarch64: %s\n' "$*" >&2; }
logged() { "$@" >>"$folder/log" 2>&1 || { tail -n 30 "$folder/log" >&2; exit 1; }; }
mkdir -p "$folder"
: >"$folder/log"

missing=()
for package in gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user-static; do
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
  as_root=()
  if [ "$(id -u)" -ne 0 ]; then as_root=(sudo); fi
  say "installing ${missing[*]}"
  logged "${as_root[@]}" apt-get update -qq
  logged "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
fi

# Python for ARM by the same mirrors, as if on an empty machine of that kind, only unpacked.
if [ ! -e "$system/usr/bin/python3" ]; then
  say "unpacking Debian's Python for ARM"
  rm -rf "$system" "$folder/apt"
  mkdir -p "$system" "$folder/apt/lists/partial" "$folder/apt/cache/archives/partial"
  : >"$folder/apt/status"
  apt=(apt-get -qq -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o APT::Sandbox::User=
    -o "Dir::State::lists=$folder/apt/lists" -o "Dir::State::status=$folder/apt/status" -o "Dir::Cache=$folder/apt/cache")
  logged "${apt[@]}" update
  logged "${apt[@]}" install --yes --download-only --no-install-recommends python3 libpython3-dev libstdc++6
  for each in "$folder"/apt/cache/archives/*.deb; do dpkg -x "$each" "$system"; done
  rm -rf "$folder/apt"
fi
version=$(readlink "$system/usr/bin/python3") # python3.11
emulated() { qemu-aarch64-static -L "$system" -E PYTHONPATH="$site" -E OMP_NUM_THREADS=1 "$system/usr/bin/python3" "$@"; }

for_arm=(--only-binary ":all:" --implementation cp --python-version "${version#python}" --target "$site"
  --platform manylinux_2_28_aarch64 --platform manylinux_2_27_aarch64 --platform manylinux_2_17_aarch64
  --platform manylinux2014_aarch64 --platform linux_aarch64)
if [ ! -e "$site/pytest" ]; then
  say "installing what ancfsparse requires, for ARM"
  "$python" - >"$folder/requirements.txt" <<'PYTHON'
import tomllib
with open("pyproject.toml", "rb") as file:
    project = tomllib.load(file)["project"]
print(*project["dependencies"], *project["optional-dependencies"]["test"], sep="\n")
PYTHON
  logged "$python" -m pip --disable-pip-version-check install "${for_arm[@]}" -r "$folder/requirements.txt"
fi

say "compiling"
cat >"$folder/cross.ini" <<INI
[binaries]
c = 'aarch64-linux-gnu-gcc'
ar = 'aarch64-linux-gnu-ar'
strip = 'aarch64-linux-gnu-strip'
[built-in options]
c_args = ['-I$system/usr/include/$version', '-I$system/usr/include'] # before the Python.h of this machine
[host_machine]
system = 'linux'
cpu_family = 'aarch64'
cpu = 'aarch64'
endian = 'little'
INI
rm -f "$folder"/ancfsparse-*.whl
PATH="$root/.venv/bin:$PATH" _PYTHON_HOST_PLATFORM=linux-aarch64 logged "$python" -m pip --disable-pip-version-check \
  wheel --no-deps --no-build-isolation --wheel-dir "$folder" "--config-settings=builddir=$folder/objects" \
  "--config-settings=setup-args=--cross-file=$folder/cross.ini" .
wheel=$(tools/name_systems.sh "$folder"/ancfsparse-*.whl)
say "made $wheel"
rm -rf "$site"/ancfsparse "$site"/ancfsparse-*
logged "$python" -m pip --disable-pip-version-check install --no-deps "${for_arm[@]}" "$wheel"

say "comparing with this machine"
PYTHONPATH=$root OMP_NUM_THREADS=1 "$python" -P tools/digits.py "$folder/here.json"
emulated -P tools/digits.py "$folder/emulated.json"
"$python" -P tools/digits.py --compare "$folder/here.json" "$folder/emulated.json"

say "running tests"
if [ $# = 0 ]; then set -- tests/threads tests/kernels/test_catalog.py; fi
# The test that is left out starts a process, which the system does not emulate by itself.
cd "$folder" # the folder of the sources has modules of this machine
emulated -P -m pytest --rootdir "$root" -c "$root/pyproject.toml" -o pythonpath="$site $root" -p no:cacheprovider -q \
  -m 'not slow' -k 'not need_no_library' "${@/#tests/$root/tests}"
