#!/usr/bin/env bash
# Copy the files of this repository, as they are now, into a repository of their own: tools/copy_sources.sh FOLDER
set -euo pipefail
mkdir -p "$1"
folder=$(cd "$1" && pwd)
cd "$(dirname "${BASH_SOURCE[0]}")/.."
git ls-files -z --cached --others --exclude-standard | while IFS= read -r -d '' file; do
  if [ -e "$file" ]; then printf '%s\0' "$file"; fi # not files deleted and still in the index
done | xargs -0 cp --parents -t "$folder"
git -C "$folder" init --quiet --initial-branch=main
git -C "$folder" add . # some tests ask git for the files
