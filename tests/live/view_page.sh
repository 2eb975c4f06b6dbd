#!/usr/bin/env bash
# tools/launch.sh --isolated --view, and its page in a headless Chromium: the page is reached from outside of the run's network namespace
# and shows live data; pause, resume, speed and stop work by keys; axe-core finds nothing serious; a browser that reads nothing delays no
# node; other hosts, origins and tokens are refused.
bin=$1
. "$(dirname "$0")/browser.sh"
. "$(dirname "$0")/namespace.sh"
. "$root/tests/live/launched.sh"
. "$root/tests/live/paged.sh"

# A session that lasts as long as the browser needs.
sed "s|^end_s:.*|end_s: 300|; s|^vision: .*|vision: $root/robots/hoap2/vision.yaml|" "$root/logs/reach.yaml" >"$work/scene.yaml"
start page --camera "render --config $work/scene.yaml"
host=${address#http://}; host=${host%%/*}; token=${address#*#}
node "$root/tests/web/page.mjs" "$address" >"$work/browser.out" 2>&1 || failures=$((failures + 1))
cat "$work/browser.out"
# upgrade ORIGIN TOKEN: the status of an attempt to get messages.
upgrade() {
  curl --silent --http1.1 --max-time 1 --output /dev/null --write-out '%{http_code}' -H 'Connection: Upgrade' -H 'Upgrade: websocket' \
    -H 'Sec-WebSocket-Version: 13' -H 'Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==' -H "Origin: $1" "http://$host/messages?token=$2"
}
if command -v curl >/dev/null; then
  [ "$(upgrade "http://$host" "$token")" = 101 ] || failed "the right token and origin are refused"
  [ "$(upgrade "http://$host" wrong)" != 101 ] || failed "a wrong token is accepted"
  [ "$(upgrade http://evil.example "$token")" != 101 ] || failed "another origin is accepted"
  [ "$(curl --silent --output /dev/null --write-out '%{http_code}' -H 'Host: evil.example' "http://$host/")" = 403 ] || failed "another host is served"
else
  echo "skipped: curl is not here: hosts, origins and tokens are tested by the unit tests only"
fi
kill -TERM $launched
ended 130

# Late ticks of two whole sessions: without a page, and with three browsers that read nothing.
launch without --isolated >/dev/null
wait $launched
without=$(report late_ticks)
start with --record "$work/with.lcm"
for _ in 1 2 3; do node "$root/tests/web/deaf.mjs" "$address" & deaf+=($!); done
wait $launched
with=$(report late_ticks)
kill "${deaf[@]}" 2>/dev/null
echo "late ticks: without a page $without, with three browsers that read nothing $with"
[ "$(report lcm_lost)" = 0 ] || echo "messages lost: $(report lcm_lost)"
[ "$(reached)" -ge 6 ] || failed "only $(reached) positions were settled: $(cat "$work/with.err")"
"$bin/multireach-log" info "$work/with.lcm" >"$work/info"
grep -q JOINT_COMMAND "$work/info" || failed "nothing is recorded: $(cat "$work/info")"
grep VISION_DEBUG_REQUEST "$work/info" && failed "vision draws for browsers that asked for nothing, and is late where others keep the processors busy"
grep -q 'page is started again\|page was killed' "$work/with.err" && failed "the page's process died"
finish
