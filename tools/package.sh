#!/usr/bin/env bash
# Build sdist and wheel of the sources as they are now, in build/package, and test them: the wheel is installed in an
# empty environment without a compiler, and runs the examples of README.md; then so with `cholmod`.
# On Linux its name then says on which systems it runs, see tools/name_systems.sh.
# It is built from the sdist, for all instruction sets; arguments go to `pip wheel`, such as
# --config-settings=setup-args=-Dinstruction_sets=native for the widest of this machine alone.
# ANCFSPARSE_WHEEL=FILE tests that wheel without compiling.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
root=$PWD
unset PYTHONPATH # the examples find the installed package alone
python=$root/.venv/bin/python
folder=$root/build/package
say() { printf 'package: %s\n' "$*" >&2; }
logged() { PATH="$root/.venv/bin:$PATH" "$@" >>"$folder/log" 2>&1 || { tail -n 30 "$folder/log" >&2; exit 1; }; }

rm -rf "$folder"
mkdir -p "$folder/unpacked"
tools/copy_sources.sh "$folder/project" # an sdist contains committed files alone
git -C "$folder/project" -c user.name=package -c user.email=package@localhost commit --quiet --message 'Sources'
say "building the sdist"
cd "$folder/project"
logged "$python" -c 'import mesonpy; mesonpy.build_sdist("..")'
cd "$folder"

if [ -n "${ANCFSPARSE_WHEEL:-}" ]; then
  cp "$ANCFSPARSE_WHEEL" .
else
  say "building the wheel from it (ten minutes for all instruction sets)"
  tar -xzf ancfsparse-*.tar.gz -C unpacked --strip-components=1
  # In a folder that stays: pip asks for the metadata first, and would compile everything for each.
  logged "$python" -m pip --disable-pip-version-check wheel --no-deps --no-build-isolation --wheel-dir . \
    "--config-settings=builddir=$folder/objects" "$@" ./unpacked
fi
rm -rf project unpacked objects
wheel=$(echo "$folder"/ancfsparse-*.whl)

if [ "$(uname -s)" = Linux ]; then
  wheel=$("$root/tools/name_systems.sh" "$wheel")
  say "made $(basename "$wheel")"
fi

"$python" -m venv empty
empty=$folder/empty/bin/python
install() { "$empty" -m pip --disable-pip-version-check --no-input --quiet install "$@"; }
run_examples() {
  "$empty" -P -c 'import ancfsparse, sys; assert ancfsparse.__file__.startswith(sys.prefix), ancfsparse.__file__'
  "$empty" -P "$root/tools/run_readme.py"
}
say "installing the wheel, with nothing that must be compiled, and running the examples"
install --only-binary :all: "$wheel"
if "$empty" -P -c 'import sksparse' 2>/dev/null; then
  say "scikit-sparse is there, which no requirement but the extra cholmod may bring"
  exit 1
fi
run_examples
say "the same with scikit-sparse, which is compiled"
install "$wheel[cholmod]"
"$empty" -P -c 'import sksparse.cholmod'
run_examples
say "both pass: $(du -h ancfsparse-* | tr '\t\n' '  ')"
