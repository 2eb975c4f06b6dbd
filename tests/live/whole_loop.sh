#!/usr/bin/env bash
# The whole session through separate processes: every reachable position is reached, nothing is lost, no limit is passed.
bin=$1
timed=yes
. "$(dirname "$0")/namespace.sh"
[ "$bin" -ef "$root/build/release/bin" ] || { echo "skipped: launch.sh runs the release build"; exit 77; }
"$root/tools/launch.sh" --no-setup --json "$work/report.json" --record "$work/run.lcm" 2>"$work/err" || failed "exit code $?: $(cat "$work/err")"
report() { tr -d ' \n' <"$work/report.json" | grep -o "\"$1\":[^,}]*" | head -n1 | cut -d: -f2; }
[ "$(tr -d ' \n' <"$work/report.json" | grep -o '"settle_s"' | wc -l)" -ge 6 ] || failed "fewer than five reachable positions and one unreachable"
[ "$(report lcm_lost)" = 0 ] || failed "messages lost: $(report lcm_lost)"
# One target for each pair of images. What the recorder lost of either, as it does on a busy machine, the sequences say.
sent() { "$bin/multireach-log" info "$work/run.lcm" | awk -v channel="$1" '$1 == channel { print $3 + $7 }'; }
[ "$(sent STEREO_IMAGES)" = "$(sent TARGET)" ] || failed "$(sent STEREO_IMAGES) pairs of images, $(sent TARGET) targets"
violation=$(report max_limit_violation_rad)
[ -n "$violation" ] || failed "no report of limits"
[ "${violation:-0.0}" = 0.0 ] || wrong "beyond a limit: $violation"
for key in setpoints commands late_ticks vision_error_mm lost_intervals reaches; do
  grep -q "\"$key\"" "$work/report.json" || failed "no $key in the report"
done
"$bin/multireach-log" report "$work/run.lcm" --robot "$root/robots/hoap2/robot.yaml" --json "$work/again.json" 2>/dev/null
cmp "$work/report.json" "$work/again.json" || failed "the recorded log gives another report"
finish
