#!/usr/bin/env bash
# Every arm with its driver and emulator, as a user starts it, one after the other. Builds them where needed. Prints a table for docs/robots.md: exit
# code, positions reached, the worst error of these, what the emulated robot and the driver refused, and where the arm stopped.
# Then, from a set-point to the wire: the time from JOINT_SETPOINT to the first JOINT_COMMAND that shows it, by arrival at the recorder; the
# time in the driver, from a JOINT_COMMAND to the bytes for the robot; and how regularly the robot was commanded.
#   bench/robots.sh [ARM ...]     default: all; so101_dynamixel is the SO-101 as if its motors were Dynamixel
set -uo pipefail
export LC_NUMERIC=C
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
bin=$root/build/release/bin
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
field() { tr -d ' \n' <"$1" | grep -o "\"$2\":[^,}]*" | cut -d: -f2; }
node_field() { tr -d ' \n' <"$1" | grep -o "\"$2\":{[^{}]*" | grep -o "\"$3\":[0-9]*" | cut -d: -f2; }

if [ $# -eq 0 ]; then set -- iiwa14 panda fr3 ur5e ur5 so101 so101_dynamixel; fi
failed=0
printf '## Reaches\n\n'
echo "| arm | driver | exit code | reached | worst error, mm | stops of the emulated robot | commands refused | restarts |"
echo "|---|---|---|---|---|---|---|---|"
for arm in "$@"; do
  folder=$root/robots/${arm%_dynamixel}
  if [ "$arm" != "${arm%_dynamixel}" ]; then
    cp -r "$folder" "$work/$arm"
    folder=$work/$arm
    sed -i 's/name: feetech/name: dynamixel/' "$folder/robot.yaml"
  fi
  driver=$(awk '/^driver:/ { found = 1 } found && /name:/ { print $2; exit }' "$folder/robot.yaml")
  out=$work/out.json
  export MULTIREACH_WIRE_REPORT=$work/$arm.wire
  XDG_STATE_HOME=$work/state "$root/tools/launch.sh" --robot "$folder" --driver "$driver" --emulator --isolated --record "$work/run.lcm" --json "$out" >"$work/report" 2>"$work/err"
  code=$?
  if [ $code -ne 0 ]; then
    failed=1
    tail -n 25 "$work/err" "$work/report" >&2
  fi
  if [ ! -s "$out" ]; then
    echo "| $arm | $driver | $code | $(tail -n 1 "$work/err") | | | | |"
    continue
  fi
  reached=$(field "$out" settle_s | grep -c '[0-9]')
  worst=$(tr -d ' \n' <"$out" | grep -o '"hand_error_mm":[0-9.e-]*[^{}]*"settle_s":[0-9]' | grep -o '"hand_error_mm":[0-9.e-]*' | cut -d: -f2 | sort -g | tail -n 1)
  refused=$(node_field "$out" robot_driver refused)
  restarts=$(field "$out" restarts | awk '{ sum += $1 } END { print sum + 0 }')
  printf '| `%s` | `%s` | %d | %d | %.2f | %s | %s | %s |\n' "$arm" "$driver" "$code" "$reached" "${worst:-nan}" \
    "$(grep -c 'emulated robot has stopped' "$work/err")" "${refused:-?}" "${restarts:-?}"
  "$bin/multireach-log" latency "$work/run.lcm" | awk '/^JOINT_SETPOINT -> JOINT_COMMAND/ { print $4, $6, $7 }' >"$work/$arm.latency"
  rm -f "$work/run.lcm"
  [ -z "${MULTIREACH_KEEP:-}" ] || cp "$out" "$MULTIREACH_KEEP/$arm.json"
done
printf '\n## On the wire\n\n'
echo "| arm | \`JOINT_SETPOINT\` to \`JOINT_COMMAND\` p50, p99, max, ms | in the driver p50, p99, max, ms | commands on the wire | period p50, p99, max, ms |"
echo "|---|---|---|---|---|"
for arm in "$@"; do
  [ -s "$work/$arm.wire" ] || continue
  median=- most_of=- longest=-
  [ ! -s "$work/$arm.latency" ] || read -r median most_of longest <"$work/$arm.latency"
  tr -d ' \n' <"$work/$arm.wire" | sed -E 's/.*"delay_ms":\{"max":([^,]*),"p50":([^,]*),"p99":([^}]*)\},"messages":([^,]*),"period_ms":\{"max":([^,]*),"p50":([^,]*),"p99":([^}]*)\}.*/\1 \2 \3 \4 \5 \6 \7/' |
    awk -v arm="$arm" -v bridge="$median, $most_of, $longest" '{ printf "| `%s` | %s | %.3f, %.3f, %.3f | %d | %.2f, %.2f, %.2f |\n", arm, bridge, $2, $3, $1, $4, $6, $7, $5 }'
done
exit $failed
