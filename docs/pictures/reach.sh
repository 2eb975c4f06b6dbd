#!/usr/bin/env bash
# Makes docs/pictures/reach.webp: the page of a recorded session, replayed, in a headless Chromium; animated by img2webp (Debian's packages
# chromium and webp). --no-setup: everything is built.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
bin=$root/build/release/bin
[ "${1:-}" = --no-setup ] || "$root/tools/setup.sh" loop page
work=$(mktemp -d)
trap 'kill $page 2>/dev/null || true; rm -rf "$work"' EXIT
"$bin/multireach-replay" run "$root/logs/reach.lcm" -o "$work/run.lcm" >/dev/null
"$bin/multireach-page" --log "$work/run.lcm" >"$work/address" 2>"$work/err" & page=$!
until grep -q 'http' "$work/address"; do kill -0 $page; sleep 0.05; done
node "$root/tests/web/animation.mjs" "$(cat "$work/address")" "$work" 0.4 9 0.2
img2webp -loop 0 -lossy -q 55 -m 6 -d 200 "$work"/0*.png -o "$root/docs/pictures/reach.webp"
