#!/usr/bin/env bash
# multireach-page --log in a headless Chromium: it plays, steps and is scrubbed; another run is shown over it with the first difference; a
# what-if run is computed; a wrong value is refused; the copied link opens the same view. bench/page.sh opens a log of a million messages.
bin=$1
skip() { echo "skipped: $1"; exit 77; }
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
chromium=$(command -v "${CHROMIUM:-chromium}") || skip "there is no Chromium (Debian's package chromium)"
export CHROMIUM=$chromium
[ -x "$bin/multireach-page" ] || skip "multireach-page is not built (tools/setup.sh page)"
command -v npm >/dev/null || skip "there is no npm"
timeout 300 "$root/web/build.sh" || skip "the page cannot be built: npm has no packages"
work=$(mktemp -d)
trap 'kill $page 2>/dev/null; rm -rf "$work"' EXIT
"$bin/multireach-replay" run "$root/logs/reach.lcm" --until 6 -o "$work/run.lcm" >/dev/null || { echo "FAILED: run"; exit 1; }
"$bin/multireach-replay" run "$root/logs/reach.lcm" --until 6 --set controller.motion=track -o "$work/track.lcm" >/dev/null || { echo "FAILED: run"; exit 1; }
"$bin/multireach-page" --log "$work/run.lcm" --compare "$work/track.lcm" >"$work/address" 2>"$work/err" & page=$!
until grep -q 'http' "$work/address" || ! kill -0 $page 2>/dev/null; do sleep 0.05; done
node "$root/tests/web/log.mjs" "$(cat "$work/address")" "${2:-}" || { cat "$work/err"; exit 1; }
# A log in which vision could choose from several things.
kill $page
mkdir "$work/types"
lcm-gen -p --ppath "$work/types" "$root"/lcmtypes/*.lcm && /usr/bin/python3 "$root/tests/web/candidates_log.py" "$work/types" "$work/run.lcm" "$work/several.lcm" ||
  { echo "FAILED: no log with candidates"; exit 1; }
"$bin/multireach-page" --log "$work/several.lcm" --robot "$root/robots/hoap2" --vision "$root/robots/hoap2/vision.yaml" >"$work/address" 2>"$work/err" & page=$!
until grep -q 'http' "$work/address" || ! kill -0 $page 2>/dev/null; do sleep 0.05; done
node "$root/tests/web/candidates.mjs" "$(cat "$work/address")" "${2:-}" || { cat "$work/err"; exit 1; }
echo "all held"
