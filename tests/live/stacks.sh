#!/usr/bin/env bash
# Two instances at once on one network, each with groups of its own: both reach, and neither receives the other's messages.
bin=$1
timed=yes
. "$(dirname "$0")/namespace.sh"
. "$root/tests/live/launched.sh"
declare -A processes
launch first --seconds 14 --record "$work/first.lcm" --group 7; processes[first]=$launched
launch second --seconds 14 --record "$work/second.lcm"; processes[second]=$launched
"$bin/multireach-robot" --lcm-url 'udpm://239.255.77.7:8014?ttl=0' pause >"$work/out" 2>&1 || failed "pause: $(cat "$work/out")"
sleep 1
"$bin/multireach-robot" status | grep -q 'running.*path rate [1-9]' || failed "a pause of the first stack stops the second"
"$bin/multireach-robot" --lcm-url 'udpm://239.255.77.7:8014?ttl=0' resume >"$work/out" 2>&1 || failed "resume: $(cat "$work/out")"
# The pause may last as long as the target stays at one of its positions: then the first stack misses that one, and says so.
for name in first second; do
  launched=${processes[$name]}
  wait "$launched"
  code=$?
  [ $name = second ] || [ $code -ne 1 ] || ! grep -q ': 1 of 4 reachable positions were not reached to 5 mm; the bridge stopped: paused$' "$work/first.err" || code=0
  [ $code -eq 0 ] || failed "$name: exit code $code, expected 0: $(cat "$work/$name.err")"
  [ "$(reached)" -ge 3 ] || failed "$name: $(reached) positions reached"
  [ "$(tr -d ' \n' <"$work/$name.json" | grep -o '"publishers":{[^}]*' | grep -c ':[2-9]')" = 0 ] || wrong "$name: hears other publishers"
  "$bin/multireach-log" export csv "$work/$name.lcm" -o "$work/$name" --channel NODE_INPUTS 2>/dev/null
done
runs() { cut -d, -f4 "$work/$1/NODE_INPUTS.csv" | sort -u; }
comm -12 <(runs first) <(runs second) | grep -qv run && wrong "both recordings hold messages of one process"
[ "$(wc -l <<<"$(runs first)")" -ge 4 ] || failed "the recording names $(runs first)"
grep -q "^launch.sh: for other programs:  export LCM_DEFAULT_URL='udpm://239.255.77.7:8014?ttl=0'$" "$work/first.err" || wrong "its groups are not said"
name=wrong
"$root/tools/launch.sh" --no-setup --group 256 2>"$work/wrong.err" && wrong "group 256"
says "^launch.sh: --group: '256' is not a number from 0 to 255$"
finish
