#!/usr/bin/env bash
# Build the documentation site in build/site, where every warning is an error; arguments go to Sphinx.
# What Sphinx needs, the extra `docs`, is installed into .venv if it is missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
python=.venv/bin/python
"$python" -m pip --disable-pip-version-check --no-input --quiet install 'ancfsparse[docs]'
"$python" -m sphinx -b html -c docs/site -W --keep-going --quiet "$@" . build/site
echo "docs: build/site/index.html" >&2
