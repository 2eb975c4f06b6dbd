#!/usr/bin/env bash
# The whole set-up course of a practice, done by a script in a headless Chromium, from an empty folder to a reach: cameras, chessboard,
# object, camera pose, check, reach. Its files are those of the command-line tools, which read them.
bin=$1
. "$(dirname "$0")/browser.sh"
[ -x "$bin/multireach-camera" ] || skip "multireach-camera is not built"
. "$(dirname "$0")/namespace.sh"
[ "$bin" -ef "$root/build/release/bin" ] || skip "launch.sh runs the release build"
unset MULTIREACH_ISOLATED

"$root/tools/launch.sh" --no-setup --practice --course "$work/course" >"$work/out" 2>"$work/err" & launched=$!
until address=$(grep -o 'http://[^ ]*' "$work/out") || ! kill -0 $launched 2>/dev/null; do sleep 0.05; done
node "$root/tests/web/course.mjs" "$address" ${PICTURES:+"$PICTURES"} >"$work/browser.out" 2>&1 || failures=$((failures + 1))
cat "$work/browser.out"
kill -TERM $launched
wait $launched
[ $failures -eq 0 ] || cat "$work/err"
for file in stereo.yaml ball.colour.yaml pose.yaml vision.yaml; do
  [ -s "$work/course/$file" ] || failed "$file is not there"
done
# The same pictures, and the camera pose, with the tools.
"$bin/multireach-calibrate" cameras --left "$work/course/board/left*.png" --right "$work/course/board/right*.png" --pattern 9x6 --square 0.025 \
  --lens radtan -o "$work/stereo.yaml" >"$work/tool.out" 2>&1 || failed "the tool does not take the pictures: $(cat "$work/tool.out")"
"$bin/multireach-vision" --config "$work/course/vision.yaml" --pair "$work/course/board/left000.png" "$work/course/board/right000.png" \
  >"$work/vision.out" 2>&1
grep -q '"lost"' "$work/vision.out" || failed "vision does not read the file: $(cat "$work/vision.out")"
! "$root/tools/launch.sh" --no-setup --practice --driver ur >/dev/null 2>"$work/err" || failed "a practice with a driver"
grep -q 'robot and cameras of its own' "$work/err" || failed "a practice with a driver: $(cat "$work/err")"
finish
