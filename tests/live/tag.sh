#!/usr/bin/env bash
# A rendered tag as a pose target through separate processes: the hand takes the tag's pose, and the recorded run verifies.
bin=$1
timed=yes
. "$(dirname "$0")/namespace.sh"
[ "$bin" -ef "$root/build/release/bin" ] || { echo "skipped: launch.sh runs the release build"; exit 77; }
"$root/tools/launch.sh" --no-setup --robot "$root/examples/tag" --record "$work/run.lcm" --json "$work/report.json" \
  >"$work/out" 2>"$work/err" || echo "launch.sh: exit code $?: $(tail -n 3 "$work/err")"
"$bin/multireach-test-pose" "$work/run.lcm" "$root/examples/tag" || failed "the hand is not at the tag's pose: $(cat "$work/out")"
table=$("$bin/multireach-replay" verify "$work/run.lcm" --robot "$root/examples/tag" --vision "$root/examples/tag/vision.yaml") ||
  failed "the run does not verify: $table"
read -r _ messages equal _ <<<"$(grep "^TARGET " <<<"$table")"
sent() { "$bin/multireach-log" info "$work/run.lcm" | awk -v channel="$1" '$1 == channel { print $3 + $7 }'; }
left_out=$(tr -d ' \n' <"$work/report.json" | grep -o '"pairs_left_out":[0-9]*' | cut -d: -f2)
[ "$(sent STEREO_IMAGES)" -eq $(($(sent TARGET) + left_out)) ] ||
  failed "$(sent STEREO_IMAGES) pairs of images, $(sent TARGET) targets, $left_out pairs left out"
[ "$messages" -gt 70 ] && [ "$equal" = "$messages" ] || failed "TARGET: $equal of $messages computed again"
finish
