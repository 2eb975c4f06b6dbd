#!/usr/bin/env bash
# tools/figures.sh draws every picture of docs/guarantees.md.
#   tests/live/figures.sh BIN_FOLDER
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
command -v gnuplot >/dev/null || { echo "skipped: gnuplot is not installed"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$root/tools/figures.sh" --into "$work/pictures" | tee "$work/said"
for name in $(grep -o 'pictures/guarantees/[a-z-]*' "$root/docs/guarantees.md" | sort -u | xargs -n 1 basename); do
  grep -q "skipped: $name" "$work/said" || grep -q '</svg>' "$work/pictures/$name.svg" || { echo "FAILED: no picture $name"; exit 1; }
done
