#!/usr/bin/env bash
# Two computers on a link that loses 1 % of the packets (seeded) and delays all by 5 ms: cameras and controller on one, bridge and robot
# on the other. All positions are reached, with clocks that agree, and with clocks that are 100 ms and 5 s apart, of which the report
# and the doctor tell. When the link is interrupted for two seconds, the arm stops on a ramp and continues by itself.
#
# The clocks: time namespaces shift the monotonic clock (by a day, tests/live/two_hosts.sh), by which the programs wait. The time of day,
# which a process reads once at its start and puts into its messages, is the kernel's and the same in all namespaces: libfaketime
# shifts it in the processes of the robot's computer. So covered are all programs and scripts of the loop and lcm-logger, not the kernel.
bin=$1
timed=yes
. "$(dirname "$0")/namespace.sh"
. "$root/tests/live/launched.sh"
. "$root/tests/live/hosts.sh"
faketime=$(find /usr/lib -name libfaketime.so.1 2>/dev/null | head -n 1)
[ -n "$faketime" ] || { echo "skipped: libfaketime is not installed"; exit 77; }
host eyes 10.0.0.1 0
host robot 10.0.0.2 0
"$bin/multireach-test-relay" to_eyes to_robot 0.01 5 2008 >"$work/relay" & relay=$!
parents+=("$relay")

for shift in 0 +0.1 -5; do
  # A preloaded library is not inherited by the programs of `on`, which run with the true time.
  on_robot=(env LD_PRELOAD="$faketime" FAKETIME="$shift" FAKETIME_DONT_FAKE_MONOTONIC=1)
  [ $shift != 0 ] || on_robot=()
  both
  on eyes "$root/tools/doctor.sh" --seconds 4 >"$work/doctor" 2>&1
  both_ended
  [ $eyes_code -eq 0 ] || failed "clock $shift s: eyes: exit code $eyes_code: $(cat "$work/eyes.err")"
  [ $robot_code -eq 0 ] || failed "clock $shift s: robot: exit code $robot_code: $(cat "$work/robot.err")"
  for name in eyes robot; do [ "$(reached)" -ge 6 ] || failed "clock $shift s: $name: $(reached) positions reached"; done
  name=eyes
  lead=$(tr -d ' \n' <"$work/eyes.json" | grep -o '"bridge":{[^}]*' | grep -o '"clock_lead_ms":[-0-9.]*' | cut -d: -f2)
  awk -v lead="$lead" -v shift="$shift" 'BEGIN { error = lead - 1000 * shift; exit !(error > -25 && error < 15) }' || failed "clock $shift s: the report of the eyes says $lead ms"
  if [ $shift = 0 ]; then
    grep -q '^clock of bridge' "$work/eyes.err" && failed "the report finds other clocks: $(cat "$work/eyes.err")"
    grep -q '^ok       the clocks of all running nodes agree' "$work/doctor" || failed "the doctor does not find that the clocks agree: $(cat "$work/doctor")"
  else
    grep -q "^FINDING  clock of bridge: [0-9]* ms .* this computer's" "$work/doctor" || failed "clock $shift s: the doctor says nothing of the clocks: $(cat "$work/doctor")"
    grep -q '^clock of bridge: ' "$work/eyes.err" || failed "clock $shift s: the report says nothing of the clocks: $(cat "$work/eyes.err")"
  fi
done

on_robot=()
both --seconds 10
interrupted
kill $relay; wait $relay
awk '/^from / { packets += $4; lost += $6 } END { exit !(packets > 20000 && lost > 0.007 * packets && lost < 0.013 * packets) }' "$work/relay" ||
  failed "the link did not lose 1 %: $(cat "$work/relay")"
[ -z "${MULTIREACH_KEEP:-}" ] || cat "$work"/{eyes,robot}.{out,err} "$work/relay"
finish
