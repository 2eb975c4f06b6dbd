#!/usr/bin/env bash
# Makes docs/pictures/view.png: the page of the recorded session, in a headless Chromium (Debian's package chromium).
# --no-setup: everything is built.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
[ "${1:-}" = --no-setup ] || "$root/tools/setup.sh" loop page
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$root/tools/launch.sh" --no-setup --isolated --view >"$work/out" 2>"$work/err" & run=$!
until address=$(grep -o 'http://[^ ]*' "$work/out"); do kill -0 $run; sleep 0.1; done
node "$root/tests/web/picture.mjs" "$address" "$root/docs/pictures/view.png"
kill -TERM $run 2>/dev/null || true
wait $run || true
