#!/usr/bin/env bash
# multireach-page --drake: what a viewer of Drake gets on the network, decoded by the code that lcm-gen writes from the definitions.
bin=$1
[ -x "$bin/multireach-page" ] || { echo "skipped: multireach-page is not built (tools/setup.sh page)"; exit 77; }
. "$(dirname "$0")/namespace.sh"
[ -e "$root/build/web/index.html" ] || { echo "skipped: the page is not built (web/build.sh)"; exit 77; }
config=$root/robots/hoap2/robot.yaml
lcm-logger --quiet --force "$work/run.lcm" & logger=$!
"$bin/multireach-robot-sim" --config "$config" 2>"$work/sim.err" & sim=$!
"$bin/multireach-page" --robot "$config" --drake >"$work/address" 2>"$work/page.err" & page=$!
sleep 2
"$bin/multireach-publish" obstacle sphere 0.3 0.1 0.2 --size 0.05 >/dev/null 2>"$work/publish.err" || failed "no obstacle: $(cat "$work/publish.err")"
sleep 7
kill $page $sim
kill -INT $logger
wait
cat "$work/page.err" "$work/sim.err"
lcm-gen -p --ppath "$work/types" "$root"/lcmtypes/drake/viewer/*.lcm || failed "lcm-gen"
/usr/bin/python3 "$root/tests/live/drake_viewer.py" "$work/types" "$work/run.lcm" || failed "the messages"
if "$bin/multireach-page" --log "$work/run.lcm" --drake >/dev/null 2>"$work/err"; then failed "--drake with --log"; fi
grep -q -- '--drake' "$work/err" || failed "--drake with --log: $(cat "$work/err")"
finish
