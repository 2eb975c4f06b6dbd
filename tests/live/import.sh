#!/usr/bin/env bash
# multireach-log import: bags that ROS's own library wrote give the session whose images they hold.
#   tests/live/import.sh BIN_FOLDER
. "$(dirname "${BASH_SOURCE[0]}")/offline.sh"
/usr/bin/python3 -c 'import rosbag, sensor_msgs.msg' 2>/dev/null || { echo "skipped: python3-rosbag and python3-sensor-msgs are not installed"; exit 77; }
"$bin/multireach-log" cut "$root/logs/reach.lcm" -o "$work/part.lcm" --until 1 >/dev/null
"$bin/multireach-log" images "$work/part.lcm" -o "$work/png" --channel STEREO_IMAGES >/dev/null
for compression in none bz2 lz4; do
  /usr/bin/python3 - "$work/png" "$work/$compression.bag" $compression <<'PYTHON' || fail "no bag with $compression"
import glob, sys
import genpy, rosbag
from sensor_msgs.msg import CompressedImage
folder, path, compression = sys.argv[1:]
with rosbag.Bag(path, "w", compression=compression, chunk_threshold=100000) as bag:
    for side in ("left", "right"):
        for k, name in enumerate(sorted(glob.glob(folder + "/*_" + side + ".png"))):
            message = CompressedImage(format="png", data=open(name, "rb").read())
            message.header.stamp = genpy.Time.from_sec(100 + k / 30)
            bag.write("/" + side, message, genpy.Time.from_sec(100 + k / 30))
PYTHON
  "$bin/multireach-log" import "$work/$compression.bag" -o "$work/$compression.lcm" --left /left --right /right --jpeg-quality 0 >"$work/said" ||
    fail "import of $compression: $(cat "$work/said")"
  "$bin/multireach-log" images "$work/$compression.lcm" -o "$work/$compression" >/dev/null
  diff -r "$work/png" "$work/$compression" >/dev/null || fail "$compression: the images are not those of the session"
done
# What multireach-log exports as a bag is one for ROS's own library.
"$bin/multireach-log" export bag "$work/part.lcm" -o "$work/exported.bag" 2>/dev/null || fail "no exported bag"
/usr/bin/python3 - "$work/exported.bag" "$work/part.lcm" <<'PYTHON' || fail "ROS's library does not read the exported bag"
import sys
import rosbag
path, session = sys.argv[1:]
recorded = open(session, "rb").read()
with rosbag.Bag(path) as bag:
    counts = {topic: info.message_count for topic, info in bag.get_type_and_topic_info().topics.items()}
    images = [(topic, message) for topic, message, _ in bag.read_messages()]
assert counts == {"/left/image_raw/compressed": 30, "/right/image_raw/compressed": 30}, counts
assert [topic for topic, _ in images[:2]] == ["/left/image_raw/compressed", "/right/image_raw/compressed"]
assert all(message.format == "jpeg" and bytes(message.data) in recorded for _, message in images)
times = [message.header.stamp.to_nsec() for topic, message in images if "left" in topic]
assert times == sorted(times) and times[0] > 10**18 and 32e6 < times[1] - times[0] < 35e6, times[:2]
PYTHON
# Two videos, of 12 and 10 images: ten pairs, each of images of the same number.
"$bin/multireach-test-video" avi "$work/left.avi" 12 64 48 && "$bin/multireach-test-video" avi "$work/right.avi" 10 64 48 || fail "no videos"
"$bin/multireach-log" import "$work/left.avi" "$work/right.avi" -o "$work/videos.lcm" >"$work/said" || fail "import of videos"
grep -q '^10 pairs of 64 x 48 pixels in 0.30 s, 33.3 ms apart; 2 images without a partner$' "$work/said" || fail "videos: $(cat "$work/said")"
"$bin/multireach-log" images "$work/videos.lcm" -o "$work/of_videos" >/dev/null
told=$("$bin/multireach-test-video" tell "$work"/of_videos/*_left.png "$work"/of_videos/*_right.png | tr '\n' ' ')
[ "$told" = "0 1 2 3 4 5 6 7 8 9 0 1 2 3 4 5 6 7 8 9 " ] || fail "the images of the videos are $told"
refuses "is not a video that can be opened" "$bin/multireach-log" import "$work/left.avi" "$work/png" -o "$work/refused.lcm"
refuses "--left is missing; expected a topic; its topics with images are /left, /right" "$bin/multireach-log" import "$work/lz4.bag" -o "$work/refused.lcm"
[ ! -e "$work/refused.lcm" ] || fail "a refused import leaves a log"
exit $failed
