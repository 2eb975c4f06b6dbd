#!/usr/bin/env bash
# The page moves the arm: a target that is dragged in a headless Chromium by mouse and keyboard, an obstacle, a push; the log of the run
# with all of it is computed again to the same bytes.
bin=$1
. "$(dirname "$0")/browser.sh"
. "$(dirname "$0")/namespace.sh"
. "$root/tests/live/launched.sh"
. "$root/tests/live/paged.sh"

sed "s|^end_s:.*|end_s: 300|; s|^vision: .*|vision: $root/robots/hoap2/vision.yaml|; /at_s: [1-9]/d" "$root/logs/reach.yaml" >"$work/scene.yaml"
start page --camera "render --config $work/scene.yaml" --record "$work/run.lcm"
node "$root/tests/web/touch.mjs" "$address" >"$work/browser.out" 2>&1 || failures=$((failures + 1))
cat "$work/browser.out"
kill -TERM $launched
ended 130
"$bin/multireach-replay" verify "$work/run.lcm" >"$work/verify.out" 2>&1 || failed "the run is not computed again to the same bytes: $(cat "$work/verify.out")"
finish
