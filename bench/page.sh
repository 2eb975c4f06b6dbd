#!/usr/bin/env bash
# Measures the page in a headless Chromium that renders in software: frames a second and script a frame with every plot, late ticks of the
# nodes with and without the browser in one run, and the time that a log of a million messages takes to open: until the page is served, and
# until a browser shows its first pictures, which includes the browser's start. Prints tables of docs/view.md.
#   bench/page.sh [--no-setup]
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
bin=$root/build/release/bin
[ "${1:-}" = --no-setup ] || "$root/tools/setup.sh" loop camera replay page >&2
work=$(mktemp -d)
started=()
trap 'kill "${started[@]}" 2>/dev/null || true; rm -rf "$work"' EXIT
now() { date +%s%6N; }

sed "s|^end_s:.*|end_s: 400|; s|^vision: .*|vision: $root/robots/hoap2/vision.yaml|" "$root/logs/reach.yaml" >"$work/scene.yaml"
"$root/tools/launch.sh" --no-setup --isolated --view --camera "render --config $work/scene.yaml" --record "$work/run.lcm" >"$work/out" 2>"$work/err" & run=$!
started+=("$run")
until address=$(grep -o 'http://[^ ]*' "$work/out"); do kill -0 $run; sleep 0.1; done
sleep 10  # until all is started
marks=("$(now)"); sleep 20
marks+=("$(now)")
node "$root/tests/web/frames.mjs" "$address" 20 >"$work/frames.json"
marks+=("$(now)"); sleep 20
marks+=("$(now)")
kill -TERM $run
wait $run || true
"$bin/multireach-log" export csv "$work/run.lcm" -o "$work/csv" --channel NODE_STATUS >/dev/null

"$bin/multireach-replay" run "$root/logs/reach.lcm" -o "$work/one.lcm" >/dev/null
"$root/bench/repeat_log.py" "$work/one.lcm" 1000000 "$work/million.lcm"
opened=()
for _ in 1 2 3; do
  before=$(now)
  dd if="$work/million.lcm" of=/dev/null bs=1M status=none
  read=$(($(now) - before))
  before=$(now)
  : >"$work/address"  # the one of the page before
  "$bin/multireach-page" --log "$work/million.lcm" >>"$work/address" 2>"$work/page.err" & page=$!
  started+=("$page")
  until grep -q http "$work/address"; do kill -0 $page; sleep 0.01; done
  ready=$(($(now) - before))
  node "$root/tests/web/opened.mjs" "$(cat "$work/address")" >"$work/opened.json"
  opened+=("$read,$ready,$(tr -d '{}' <"$work/opened.json")")
  kill $page
  wait $page || true
done
/usr/bin/python3 "$root/bench/page_table.py" "$work" "${marks[@]}" "${opened[@]}"
