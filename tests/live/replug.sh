#!/usr/bin/env bash
# Cameras as FIFOs, whose writers are what is plugged in: one that is unplugged, plugged in again, sends garbage or another size is
# reported, and the program continues.
bin=$1
. "$(dirname "$0")/namespace.sh"
. "$root/tests/live/recording.sh"

# One camera each, at some 30 Hz. A writer whose FIFO has no reader any more ends by itself.
mkfifo left right
for size in 320x240 640x480; do "$video" jpeg $size.jpg 3 ${size%x*} ${size#*x}; done
head -c 60000 /dev/urandom >garbage
head -c 900 320x240.jpg >damaged.jpg
plug() { (while cat "$2" && sleep 0.03; do :; done >"$1") 2>/dev/null & }
unplug() { kill "$1" 2>/dev/null; wait "$1" 2>/dev/null; }
cat >cameras.yaml <<EOF
left: left
right: $work/right
width_px: 320
height_px: 240
max_skew_ms: 30
EOF
begin_recording fifos
timeout 20 "$bin/multireach-camera" device --config cameras.yaml 2>fifos.err & camera=$!
plug left 320x240.jpg; left=$!
plug right 320x240.jpg; right=$!
sleep 1.5
unplug $right
sleep 1.3
plug right 320x240.jpg; right=$!
sleep 1.8
cat garbage damaged.jpg >right
unplug $right
plug right 640x480.jpg; right=$!
sleep 2.4
unplug $right
plug right 320x240.jpg; right=$!
sleep 1.8
unplug $left
sleep 1.2
kill $camera; wait $camera || failed "fifos: exit code $?: $(cat fifos.err)"
unplug $right
end_recording
[ "$(pairs fifos)" -gt 60 ] || failed "fifos: only '$(pairs fifos)' pairs in six seconds"
expect_logged fifos "right camera $work/right is gone, trying again"
expect_logged fifos "right camera $work/right gives images of 640 x 480 pixels, not 320 x 240"
expect_logged fifos "left camera left is gone, trying again"
expected='running right.gone running right.640 running left.gone'
was=$(states fifos | sed -n 's/^running.*/running/p; s/^right.*gone.*/right.gone/p; s/^right.*640 x 480.*/right.640/p; s/^left.*gone.*/left.gone/p' | uniq | tr '\n' ' ')
# Between two sizes the FIFO is without a writer for a moment.
case "${was//right.gone right.640 right.gone/right.640}" in
  *running*right.gone*running*right.640*running*left.gone*) ;;
  *) failed "fifos: the states were '$was', expected '$expected': $(states fifos)" ;;
esac
states fifos | grep -qE '^running, skew -?[0-9.]+ ms, max [0-9.]+, [0-9]+ unpaired$' || failed "the skew is not reported: $(states fifos)"
finish
