#!/usr/bin/env bash
# The page's port speaks Foxglove's protocol: its reference client, @foxglove/ws-protocol from npm, gets the topics of a running system.
bin=$1
[ -x "$bin/multireach-page" ] || { echo "skipped: multireach-page is not built (tools/setup.sh page)"; exit 77; }
if [ -z "${MULTIREACH_FOXGLOVE_CLIENT:-}" ]; then  # the test's own network has no way to npm
  command -v npm >/dev/null || { echo "skipped: npm is not here"; exit 77; }
  MULTIREACH_FOXGLOVE_CLIENT=$(mktemp -d)
  export MULTIREACH_FOXGLOVE_CLIENT
  cp "$(dirname "$0")"/../foxglove/* "$MULTIREACH_FOXGLOVE_CLIENT"
  timeout 120 "$(dirname "$0")/../../web/build.sh" || { echo "skipped: the page cannot be built: npm has no packages"; exit 77; }
  (cd "$MULTIREACH_FOXGLOVE_CLIENT" && npm install --no-audit --no-fund --silent) || { echo "skipped: @foxglove/ws-protocol cannot be had from npm"; exit 77; }
fi
. "$(dirname "$0")/namespace.sh"
trap 'rm -rf "$work" "$MULTIREACH_FOXGLOVE_CLIENT"' EXIT
. "$root/tests/live/launched.sh"
. "$root/tests/live/paged.sh"
watch() { node "$MULTIREACH_FOXGLOVE_CLIENT/watch.js" "ws://$1/foxglove?token=$2" 4; }

start run
host=${address#http://}; host=${host%%/*}; token=${address#*#}
watch "$host" "$token" >"$work/topics" 2>"$work/watch.err" || failed "the client: $(cat "$work/watch.err")"
cat "$work/topics"
grep -qx 'server multireach' "$work/topics" || failed "no serverInfo"
for topic in "/tf foxglove.FrameTransforms" "/scene foxglove.SceneUpdate" "TARGET multireach.target_t" "ROBOT_STATE multireach.robot_state_t" \
  "STEREO_IMAGES/left foxglove.CompressedImage" "STEREO_IMAGES/right/calibration foxglove.CameraCalibration"; do
  grep -qE "^$topic [0-9]{2,}$" "$work/topics" || failed "not 10 messages of '$topic'"
done
if watch "$host" wrong >"$work/wrong" 2>&1; then failed "a wrong token is accepted: $(cat "$work/wrong")"; fi
kill -TERM $launched
ended 130
finish
