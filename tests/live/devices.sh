#!/usr/bin/env bash
# Cameras as video files: pairs of the frames that belong together. Wrong use is refused. Where v4l2loopback can be loaded, a real
# device too.
bin=$1
. "$(dirname "$0")/namespace.sh"
. "$root/tests/live/recording.sh"

# Files: every frame, left k with right k.
"$video" avi left.avi 30 320 240; "$video" avi right.avi 30 320 240; "$video" avi both.avi 20 640 240
record files "$bin/multireach-camera" device --left left.avi --right right.avi --rate 60 || failed "files: exit code $?: $(cat files.err)"
[ "$(pairs files)" = 30 ] || failed "files: '$(pairs files)' pairs of 30"
expect_logged files "gives no more images"
"$bin/multireach-log" images files.lcm -o files.png 2>/dev/null
for side in left right; do
  [ "$("$video" tell files.png/*_$side.png | tr '\n' ' ')" = "$(seq -s ' ' 0 29) " ] || failed "files: not the frames in order: $("$video" tell files.png/*_$side.png | tr '\n' ' ')"
done
# A video is of another time than now: what follows from it may move no real robot.
first=$("$bin/multireach-log" export pairs files.lcm -o files.pairs >/dev/null 2>&1; awk -F, 'NR == 2 { print $1 }' files.pairs/pairs.csv)
[ "$first" = 0.000000 ] || failed "files: the first pair is of $first, not of 0"
record side "$bin/multireach-camera" device --side-by-side both.avi --rate 100 --width 320 --height 240 || failed "side by side: $(cat side.err)"
[ "$(pairs side)" = 20 ] || failed "side by side: '$(pairs side)' pairs of 20"
head -c 12000 left.avi >cut.avi
record cut "$bin/multireach-camera" device --left cut.avi --right right.avi --rate 100 || failed "a file that is cut off: exit code $?: $(cat cut.err)"
[ "$(pairs cut)" -lt 30 ] || failed "a file that is cut off gives all its images"

# Wrong use: one sentence, exit code 2.
fail() { failed "$1"; }
. "$root/tests/live/refuses.sh"
device() { local sentence=$1; shift; refuses "$sentence" timeout 5 "$bin/multireach-camera" device "$@"; }
device "'right.txt': is neither a camera device nor a video" --left left.avi --right right.txt
device "has images of 320 x 240 pixels, not 640 x 480 as asked" --left left.avi --right right.avi --width 640 --height 480
device "give --left and --right, or --side-by-side"
head -c 60000 /dev/urandom >garbage
device "'garbage': is neither a camera device nor a video that can be opened" --left garbage --right right.avi
device "--speed must be 1" --left left.avi --right right.avi --speed 2
device "/dev/null': is not a camera device" --left /dev/null --right right.avi
printf 'left: 0\nrate: 30\nright: 1\n' >bad.yaml
device "bad.yaml:2: key 'rate' is not known" --config bad.yaml

# multireach-view requests pictures; without vision none arrives.
begin_recording asked
"$bin/multireach-view" --picture "$work/picture.jpg" --seconds 1.5 2>view.err; code=$?
end_recording
[ $code -eq 1 ] && grep -q "no picture received" view.err || failed "without a picture: exit code $code: $(cat view.err)"
[ ! -e picture.jpg ] || failed "a picture that nobody sent"
"$bin/multireach-log" info asked.control.lcm | grep -q 'VISION_DEBUG_REQUEST *debug_request_t *2' || failed "not two requests: $("$bin/multireach-log" info asked.control.lcm)"

loopback() { modprobe v4l2loopback devices=1 video_nr=77 2>/dev/null && [ -c /dev/video77 ] && command -v ffmpeg >/dev/null; }
if loopback; then
  ffmpeg -loglevel error -re -stream_loop -1 -i both.avi -pix_fmt yuyv422 -f v4l2 /dev/video77 & player=$!
  sleep 1
  record loopback "$bin/multireach-camera" --seconds 2 device --side-by-side 77 --width 320 --height 240 || failed "loopback: $(cat loopback.err)"
  [ "$(pairs loopback)" -gt 20 ] || failed "loopback: '$(pairs loopback)' pairs in two seconds"
  kill $player; wait $player 2>/dev/null
else
  echo "not tested: a V4L2 device (v4l2loopback cannot be loaded, or there is no ffmpeg)"
fi
finish
