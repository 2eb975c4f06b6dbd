#!/usr/bin/env bash
# What `multireach-log export mcap` writes is read by the reference library of the format, @mcap/core from npm.
bin=$1
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
command -v npm >/dev/null || { echo "skipped: npm is not here"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp "$root"/tests/mcap/* "$work"
(cd "$work" && npm install --no-audit --no-fund --silent) || { echo "skipped: @mcap/core cannot be had from npm"; exit 77; }
"$bin/multireach-replay" run "$root/logs/reach.lcm" --until 3 -o "$work/run.lcm" >/dev/null || { echo "FAILED: run"; exit 1; }
"$bin/multireach-log" export mcap "$work/run.lcm" -o "$work/run.mcap" || { echo "FAILED: export"; exit 1; }
node "$work/read.js" "$work/run.mcap" >"$work/topics" || { echo "FAILED: it cannot be read"; exit 1; }
cat "$work/topics"
for topic in "STEREO_IMAGES/left foxglove.CompressedImage 90" "TARGET multireach.target_t 90" "JOINT_SETPOINT multireach.joint_setpoint_t 90" \
  "STEREO_IMAGES/left/calibration foxglove.CameraCalibration [1-9][0-9]*" "/tf foxglove.FrameTransforms [1-9][0-9]*" "/scene foxglove.SceneUpdate [1-9][0-9]*"; do
  grep -qx "$topic" "$work/topics" || { echo "FAILED: not '$topic'"; exit 1; }
done
echo "all held"
