#!/usr/bin/env bash
# Build the compiled modules with the address and undefined-behaviour sanitizers, for the instruction
# set in use, into a folder of their own, and run tests through them: tools/sanitize.sh [pytest options]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
python=$PWD/.venv/bin/python
export PATH=$PWD/.venv/bin:$PATH
folder=build/sanitize
flags='-fno-omit-frame-pointer -fno-sanitize-recover=all -g1'
set=$("$python" -c 'from ancfsparse.dispatch import instruction_set; print(instruction_set())')

[ -f "$folder/build.ninja" ] ||
  meson setup "$folder" -Db_sanitize=address,undefined -Db_lundef=false -Dc_args="$flags" >/dev/null
# Modules of this set, and those that all sets share; of blocks all sets, which one test of seeds compares.
ninja -C "$folder" -t targets all | sed -nE 's/^([^/ ]*\.(cpython.*|abi3)\.so):.*/\1/p' |
  awk -v own="_$set[.]" '/^blocks_/ || $0 ~ own || !/_(x86_64|x86_64_v[34]|aarch64)[.]/' |
  xargs ninja -C "$folder"

# The package as it stands, with these modules; and an interpreter that finds them there first, and all
# else in .venv.
stage=$PWD/$folder/stage
rm -rf "$stage" && mkdir -p "$stage/ancfsparse/compiled" "$stage/ancfsparse/generator"
find "$PWD/ancfsparse" -mindepth 1 -maxdepth 1 ! -name compiled -exec ln -s -t "$stage/ancfsparse" {} +
ln -s "$PWD/codegen" "$stage/ancfsparse/generator/"
ln -s "$PWD/$folder"/*.so "$stage/ancfsparse/compiled/"
[ -d "$folder/venv" ] || "$python" -m venv --without-pip "$folder/venv"
site='import sysconfig; print(sysconfig.get_path("purelib"))'
printf '%s\n' "$stage" "$("$python" -c "$site")" >"$("$folder/venv/bin/python" -c "$site")/sanitize.pth"

# CPython and NumPy keep memory to their end, so leaks are not looked for.
library() { "${CC##* }" -print-file-name="$1"; }
CC=${CC:-cc}
export LD_PRELOAD="$(library libasan.so) $(library libubsan.so) $(library libstdc++.so.6)"
export ASAN_OPTIONS=detect_leaks=0:abort_on_error=1 UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
export PYTHONMALLOC=malloc
# pytest puts these folders first; in the second is `codegen`, and the package that is not compiled.
# Tests that compare instruction sets would miss the others, and one that leaves no memory has none for the sanitizer.
# They write their reports to the descriptor that pytest captures by default, and end the process.
"$folder/venv/bin/python" -m pytest --capture=sys -o pythonpath="$stage ." -k 'not instruction_set and not lack_of_memory' "$@"
