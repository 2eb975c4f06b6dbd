#!/usr/bin/env bash
# Every arm with its driver and emulator, as a user starts it, one after the other. Prints a table for docs/robots.md: exit code, places
# reached, the worst error of these, what the emulated robot and the driver refused, and where the arm stopped.
# Then, how regularly each robot was commanded on its wire, and how late after the newest JOINT_COMMAND, at the driver.
#   bench/robots.sh [ARM ...]     default: all; so101_dynamixel is the SO-101 as if its motors were Dynamixel
set -uo pipefail
export LC_NUMERIC=C
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
field() { tr -d ' \n' <"$1" | grep -o "\"$2\":[^,}]*" | cut -d: -f2; }
node_field() { tr -d ' \n' <"$1" | grep -o "\"$2\":{[^{}]*" | grep -o "\"$3\":[0-9]*" | cut -d: -f2; }

if [ $# -eq 0 ]; then set -- iiwa14 panda fr3 ur5e ur5 so101 so101_dynamixel; fi
failed=0
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
  XDG_STATE_HOME=$work/state "$root/tools/launch.sh" --no-setup --robot "$folder" --driver "$driver" --emulator --isolated --json "$out" >"$work/report" 2>"$work/err"
  code=$?
  [ $code -eq 0 ] || failed=1
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
  [ -z "${MULTIREACH_KEEP:-}" ] || cp "$out" "$MULTIREACH_KEEP/$arm.json"
done
echo
echo "| arm | commands on the wire | period p50, p99, max, ms | after \`JOINT_COMMAND\` p50, p99, max, ms |"
echo "|---|---|---|---|"
for arm in "$@"; do
  [ -s "$work/$arm.wire" ] || continue
  tr -d ' \n' <"$work/$arm.wire" | sed -E 's/.*"delay_ms":\{"max":([^,]*),"p50":([^,]*),"p99":([^}]*)\},"messages":([^,]*),"period_ms":\{"max":([^,]*),"p50":([^,]*),"p99":([^}]*)\}.*/\1 \2 \3 \4 \5 \6 \7/' |
    awk -v arm="$arm" '{ printf "| `%s` | %d | %.2f, %.2f, %.2f | %.2f, %.2f, %.2f |\n", arm, $4, $6, $7, $5, $2, $3, $1 }'
done
exit $failed
