#!/usr/bin/env bash
# A detector of one's own and vision publish TARGET at the same time, each under its names: the controller follows the one that
# its configuration names, and the recorded run verifies.
bin=$1
timed=yes
. "$(dirname "$0")/namespace.sh"
[ "$bin" -ef "$root/build/release/bin" ] || { echo "skipped: launch.sh runs the release build"; exit 77; }
cp -r "$root/robots/hoap2" "$work/hoap2"
sed -i 's/^controller:/&\n  target_name: mine/' "$work/hoap2/robot.yaml"
"$bin/example-detector" 400 &
detector=$!
"$root/tools/launch.sh" --no-setup --robot "$work/hoap2" --vision "$root/robots/hoap2/vision.yaml" --session "$root/logs/reach.lcm" \
  --seconds 8 --record "$work/run.lcm" --json "$work/report.json" >"$work/out" 2>"$work/err"
kill "$detector" 2>/dev/null
wait "$detector" 2>/dev/null
# The hand goes round with the detector's target, 1 cm from (0.1, -0.12, 0.1); by now vision's ball is 10 cm away.
"$bin/multireach-log" export csv "$work/run.lcm" -o "$work/csv" >/dev/null || failed "the log cannot be exported"
awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i; next }
  { x = $column["hand_position_m[0]"]; y = $column["hand_position_m[1]"]; z = $column["hand_position_m[2]"] }
  END { r = sqrt((x - 0.1)^2 + (y + 0.12)^2 + (z - 0.1)^2); print "the hand is", r, "m from the middle of the circle"; exit !(r > 0.007 && r < 0.013) }' \
  "$work/csv/CONTROLLER_STATE.csv" || failed "the hand does not follow the detector: $(cat "$work/err")"
table=$("$bin/multireach-replay" verify "$work/run.lcm" --robot "$work/hoap2" --vision "$root/robots/hoap2/vision.yaml") ||
  failed "the run does not verify: $table"
read -r _ messages equal different unchecked _ <<<"$(grep "^TARGET " <<<"$table")"
[ "$equal" -gt 150 ] && [ "$different" = 0 ] && [ "$unchecked" -gt 150 ] || failed "TARGET: $table"
finish
