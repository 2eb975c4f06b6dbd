#!/usr/bin/env bash
# The bundled sessions are the files that they are said to be; the one recorded live verifies; the damaged one loses what is
# damaged and no more.
bin=$1
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
failures=0
failed() { echo "FAILED: $1"; failures=$((failures + 1)); }
(cd "$root/logs" && sha256sum --check --quiet SHA256SUMS) || failed "a session is another file than in SHA256SUMS"
table=$("$bin/multireach-replay" verify "$root/logs/load.lcm") || failed "load.lcm does not verify: $table"
for channel in TARGET JOINT_SETPOINT CONTROLLER_STATE JOINT_COMMAND; do
  read -r _ messages equal _ <<<"$(grep "^$channel " <<<"$table")"
  [ "$equal" -gt 100 ] && [ "$equal" = "$messages" ] || failed "$channel: $equal of $messages"
done
said=$("$bin/multireach-log" check "$root/logs/damaged.lcm") && failed "damaged.lcm is said to be sound"
echo "$said"
[ "$(grep -c 'hold no valid event' <<<"$said")" = 2 ] && grep -q 'was cut off' <<<"$said" || failed "not two damaged places and the end"
"$bin/multireach-log" check "$root/logs/reach.lcm" | grep -q sound || failed "reach.lcm is not sound"
[ $failures -eq 0 ] && echo "all held"
exit $((failures > 0))
