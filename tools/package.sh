#!/usr/bin/env bash
# Build sdist and wheel of the sources as they are now, in build/package, and test them: the wheel is
# installed in an empty environment without a compiler, and runs the examples of README.md; then so with `cholmod`.
# It is built from the sdist, for all instruction sets; arguments go to `pip wheel`, such as
# --config-settings=setup-args=-Dinstruction_sets=native for the widest of this machine alone.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
root=$PWD
python=$root/.venv/bin/python
folder=$root/build/package
say() { printf 'package: %s\n' "$*" >&2; }

rm -rf "$folder"
mkdir -p "$folder"
tools/copy_sources.sh "$folder/project" # an sdist contains what is committed
git -C "$folder/project" -c user.name=package -c user.email=package@localhost commit --quiet --message 'Sources'

say "building the sdist"
(cd "$folder/project" && PATH="$root/.venv/bin:$PATH" "$python" -c 'import mesonpy; mesonpy.build_sdist("..")') >"$folder/log" 2>&1 ||
  { tail -n 30 "$folder/log" >&2; exit 1; }
say "building the wheel from it, for all instruction sets (some minutes)"
PATH="$root/.venv/bin:$PATH" "$python" -m pip --disable-pip-version-check wheel --no-deps --no-build-isolation \
  --wheel-dir "$folder" "$@" "$folder"/ancfsparse-*.tar.gz >>"$folder/log" 2>&1 || { tail -n 30 "$folder/log" >&2; exit 1; }
wheel=$(echo "$folder"/ancfsparse-*.whl)
rm -rf "$folder/project"

# Everything that is installed here must be a wheel, so that no compiler is needed.
"$python" -m venv "$folder/empty"
empty=$folder/empty/bin/python
install() { "$empty" -m pip --disable-pip-version-check --no-input --quiet install "$@"; }
examples() {
  (cd "$folder" && "$empty" -P "$root/tools/run_readme.py")
}
say "installing the wheel without a compiler, and running the examples"
install --only-binary :all: "$wheel"
"$empty" -P -c '
import ancfsparse, importlib.util, sys
assert ancfsparse.__file__.startswith(sys.prefix), ancfsparse.__file__
assert importlib.util.find_spec("sksparse") is None'
examples
say "the same with scikit-sparse, which is compiled"
install "$wheel[cholmod]"
"$empty" -P -c 'import sksparse.cholmod'
examples
say "both pass: $(ls -sh "$folder"/ancfsparse-* | sed "s#$folder/##" | tr '\n' ' ')"
