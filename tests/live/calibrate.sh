#!/usr/bin/env bash
# multireach-calibrate on the real chessboards of Debian's opencv-doc: as good as can be, in every format, and unusable input in
# one sentence.
#   tests/live/calibrate.sh BIN_FOLDER
. "$(dirname "${BASH_SOURCE[0]}")/offline.sh"
calibrate="$bin/multireach-calibrate"

# The hand at eight positions, seen by cameras that stand at (1, 2, 3) and look as W does.
table() { awk -v line="$1" 'BEGIN { print "seen_x_m,seen_y_m,seen_z_m,hand_x_m,hand_y_m,hand_z_m"
  for (k = 0; k < 8; ++k) { x = line ? k / 10 : (k % 2) / 10; y = line ? k / 5 : int(k / 2) % 2 / 10; z = line ? 1 : 0.5 + int(k / 4) / 10
    print x "," y "," z "," x + 1 "," y + 2 "," z + 3 } }' >"$work/pairs.csv"; }
table 0
"$calibrate" hand-eye --pairs "$work/pairs.csv" -o "$work/pose.yaml" --json "$work/pose.json" >"$work/out" || fail "hand-eye"
grep -q 'positions used 8 of 8, 0.00 mm rms' "$work/out" || fail "hand-eye says $(cat "$work/out")"
table 1
ends_with 1 "lie on a line" "$calibrate" hand-eye --pairs "$work/pairs.csv" -o "$work/line.yaml"
[ -e "$work/line.yaml" ] && fail "a result that is none was written"
refuses "either --log or --pairs" "$calibrate" hand-eye -o "$work/x.yaml"
refuses "nothing.csv: cannot be opened" "$calibrate" hand-eye --pairs nothing.csv -o "$work/x.yaml"
refuses "has no column 'seen_x_m'" "$calibrate" hand-eye --pairs "$root/README.md" -o "$work/x.yaml"
refuses "--offset: 'far' is not a number" "$calibrate" hand-eye --pairs "$work/pairs.csv" --offset far -o "$work/x.yaml"
refuses "holds no ROBOT_STATE" "$calibrate" hand-eye --log "$root/logs/reach.lcm" --robot "$root/robots/hoap2/robot.yaml" \
  --vision "$root/robots/hoap2/vision.yaml" -o "$work/x.yaml"

# In the recorded session the hand goes where the vision file says that the ball is: it would give the file's own pose back.
"$bin/multireach-replay" run "$root/logs/reach.lcm" -o "$work/run.lcm" >"$work/out" 2>&1 || fail "replay: $(cat "$work/out")"
"$calibrate" hand-eye --log "$work/run.lcm" --robot "$root/robots/hoap2/robot.yaml" --vision "$root/robots/hoap2/vision.yaml" \
  -o "$work/seen.yaml" >"$work/out" 2>"$work/err"
[ $? -eq 1 ] || fail "hand-eye takes a ball that the hand does not hold"
grep -q "the target moves while the hand stands still" "$work/err" || fail "hand-eye says $(cat "$work/err")"

# Another format and back.
vision="$root/robots/hoap2/vision.yaml"
sed -n '/^cameras:/,/^colour:/p' "$vision" | sed '$d' >"$work/cameras.yaml"
"$calibrate" convert "$work/cameras.yaml" -o "$work/rig.yml" || fail "convert to OpenCV"
"$calibrate" convert "$work/rig.yml" -o "$work/camchain.yaml" || fail "convert to Kalibr"
"$calibrate" convert "$work/camchain.yaml" -o "$work/left.yaml" -o "$work/right.yaml" || fail "convert to ROS"
"$calibrate" convert "$work/left.yaml" "$work/right.yaml" -o "$work/back.yaml" 2>"$work/err" || fail "convert from ROS"
grep -q 'no R and T' "$work/err" || fail "what is assumed of camera_info is not said"
grep -q 'fx_px: 301.2$' "$work/back.yaml" || fail "the focal length has changed"
refuses "left and right are swapped" "$calibrate" convert "$work/right.yaml" "$work/left.yaml" -o "$work/x.yml"
grep -v -e image_ -e unit "$work/rig.yml" >"$work/bare.yml"
refuses "does not say the images' size" "$calibrate" convert "$work/bare.yml" --unit m -o "$work/x.yaml"
refuses "does not say the unit" "$calibrate" convert "$work/bare.yml" --size 320x240 -o "$work/x.yaml"
refuses "images of another size" "$calibrate" convert "$work/bare.yml" --size 640x480 --unit m -o "$work/x.yaml"
refuses "is its unit another one?" "$calibrate" convert "$work/bare.yml" --size 320x240 --unit mm -o "$work/x.yaml"
refuses "expected one of m, cm, mm, inch" "$calibrate" convert "$work/bare.yml" --size 320x240 --unit foot -o "$work/x.yaml"
refuses "expected WxH" "$calibrate" convert "$work/bare.yml" --size 320 --unit m -o "$work/x.yaml"
refuses "expected -o LEFT -o RIGHT" "$calibrate" convert "$work/rig.yml" --format ros -o "$work/x.yaml"
refuses "expected one of vision, opencv, ros, kalibr" "$calibrate" convert "$work/rig.yml" --format matlab -o "$work/x.yaml"
refuses "is no calibration of two cameras" "$calibrate" convert "$root/robots/hoap2/robot.yaml" -o "$work/x.yaml"
head -c 4096 /dev/urandom >"$work/garbage.yaml"
"$calibrate" convert "$work/garbage.yaml" -o "$work/x.yaml" 2>"$work/err"
[ $? -eq 2 ] && grep -qF "garbage.yaml:" "$work/err" || fail "garbage: $(cat "$work/err")"
refuses "/nowhere/x.yaml: cannot be written" "$calibrate" convert "$work/rig.yml" -o /nowhere/x.yaml
[ -e "$work/x.yaml" ] && fail "a refused input has an output"

mkdir "$work/empty" "$work/mixed"
of_board() { echo "$calibrate" cameras --pattern $1 --square $2 -o "$work/out.yaml" "${@:3}"; }
cameras() { of_board 9x6 0.025 "$@"; }
refuses "--left: no file matches" $(cameras --left "$work/empty" --right "$work/empty")
refuses "is not an image" $(cameras --left "$vision" --right "$root/README.md")
refuses "--pattern is '9'; expected WxH" $(of_board 9 0.025 --left x --right x)
refuses "'0' is not a finite number" $(of_board 9x6 0 --left x --right x)

data=/usr/share/doc/opencv-doc/examples/data
if [ ! -r $data/left01.jpg ]; then
  echo "the photographs of Debian's opencv-doc are not here; the rest held"
  [ $failed -eq 0 ] && exit 77
  exit $failed
fi
# Colours, from a photograph: by a click, by a rectangle, and a picture that is no good.
photographs="$root/../shared/data/moebius"
if [ -d "$photographs" ]; then
  "$bin/multireach-calibrate" colour --left "$photographs/view1.png" --click-left 225,245 --right "$photographs/view5.png" --rectangle-right 162,225,41,46 \
    -o "$work/pink.yaml" --picture "$work/pink.png" --json "$work/pink.json" 2>"$work/err" || fail "colour: $(cat "$work/err")"
  sed '/^colour:/,/tolerance/d' "$root/tests/data/moebius/vision.yaml" >"$work/pink.vision.yaml"
  echo "colour: {file: pink.yaml}" >>"$work/pink.vision.yaml"
  depth=$("$bin/multireach-vision" --config "$work/pink.vision.yaml" --pair "$photographs/view1.png" "$photographs/view5.png" | awk '$1 == "\"depth_m\":" { print $2 + 0 }')
  awk -v z="$depth" 'BEGIN { exit !(z > 1.876 && z < 1.930) }' || fail "the solid whose colour was learned is seen at '$depth' m"
  # Red things are many there: the answer names them.
  sed '/^colour:/,/tolerance/d' "$root/tests/data/moebius/vision.yaml" >"$work/red.vision.yaml"
  echo "colour: {references: [{rgb: [200, 60, 60]}], tolerance: 0.2}" >>"$work/red.vision.yaml"
  "$bin/multireach-vision" --config "$work/red.vision.yaml" --pair "$photographs/view1.png" "$photographs/view5.png" >"$work/red.json"
  [ $? -eq 1 ] && grep -q '"status": "ambiguous"' "$work/red.json" && grep -q '"it could be the target as well"' "$work/red.json" ||
    fail "several red things: $(cat "$work/red.json")"
  colour() { echo "$bin/multireach-calibrate colour --left $photographs/view1.png -o $work/none.yaml $*"; }
  refuses "say where the object is" $(colour)
  refuses "--rectangle-left: 400,300,100,100 is not inside" $(colour --rectangle-left 400,300,100,100)
  refuses "--click-left: '12' is not X,Y in whole pixels" $(colour --click-left 12)
  refuses "windows cannot be shown on this display" env -u DISPLAY -u WAYLAND_DISPLAY $(colour --in-window)
  refuses "windows cannot be shown on this display" env -u WAYLAND_DISPLAY DISPLAY=:9876 $(colour --in-window)
  refuses "nothing.png" $(colour --click-left 225,245 --right "$work/nothing.png" --click-right 1,1)
  # Several pictures: each has the clicks that follow it.
  right="$photographs/view5.png"
  "$bin/multireach-calibrate" colour --left "$photographs/view1.png" --click-left 225,245 --left "$right" --click-left 182,248 \
    --without-left $data/left01.jpg -o "$work/two.yaml" --json "$work/two.json" 2>"$work/err" || fail "two pictures: $(cat "$work/err")"
  [ "$(grep -c '"kept"' "$work/two.json")" -eq 6 ] || fail "expected the rates of two cameras and of two pictures of each"
  [ "$(grep -c '"file"' "$work/two.json")" -eq 6 ] || fail "expected three pictures of each camera"
  refuses "--click-left 225,245: with several pictures, give it after the --left" \
    "$calibrate" colour --click-left 225,245 --left "$photographs/view1.png" --left "$right" -o "$work/none.yaml"
  # A click beside the object in one of them.
  $(colour --click-left 225,245 --left "$right" --click-left 20,20) 2>"$work/err"
  [ $? -eq 1 ] && grep -q "without $right the rest passes, but by their colours vision would take what is at 18[0-9],24[0-9] in $right" "$work/err" ||
    fail "a click beside the object: $(cat "$work/err")"
  refuses "--without-left $photographs/view1.png: this picture is given twice, first as --left" \
    $(colour --click-left 225,245 --without-left "$photographs/view1.png")
  refuses "--picture: $right is also --right" $(colour --click-left 225,245 --right "$right" --click-right 182,248 --picture "$right")
  refuses "--in-window" $(colour --in-window --click-left 225,245)
  cp "$photographs/view1.png" "$work/another.png"
  $(colour --click-left 225,245 --without-left "$work/another.png") 2>"$work/err"
  [ $? -eq 1 ] && grep -q "which is not there; take away what has the object's colours" "$work/err" || fail "without: $(cat "$work/err")"
  refuses "view5.png: say where the object is" $(colour --click-left 225,245 --left "$right")
  refuses "expected one --rectangle-left, or --click-left only" $(colour --click-left 225,245 --rectangle-left 200,230,40,40)
  ends_with 1 "at least 40 of its pixels" $(colour --rectangle-left 1,1,3,3)
  [ ! -e "$work/none.yaml" ] || fail "a refused run leaves a file"
fi
set -f  # the patterns are the program's
boards="--left $data/left[01]?.jpg --right $data/right[01]?.jpg"
$(cameras $boards --leave-one-out --json "$work/real.json" --picture "$work/real.png") >"$work/out" 2>"$work/err" || fail "calibration: $(cat "$work/err")"
cat "$work/out"
value() { awk -v key="\"$1\":" '$1 == key { print $2 + 0; exit }' "$work/real.json"; }
[ "$(value pairs_used)" -eq 13 ] || fail "not all 13 pairs are used"
awk -v rms="$(value stereo_rms_px)" -v left="$(value median_squares)" 'BEGIN { exit !(rms > 0.1 && rms <= 0.22 && left > 0.001 && left <= 0.02) }' ||
  fail "stereo rms $(value stereo_rms_px) px, left-out boards $(value median_squares) squares"
head -c 8 "$work/real.png" | grep -q PNG || fail "no picture"
printf 'cameras: {file: out.yaml, left_to_robot: {file: pose.yaml}}\ncolour: {references: [{rgb: [220, 40, 110]}]}\n' >"$work/vision.yaml"
"$bin/multireach-vision" --config "$work/vision.yaml" --pair $data/left01.jpg $data/right01.jpg >"$work/out" 2>"$work/err"
grep -q '"lost"' "$work/out" || fail "the vision stage does not take the calibration: $(cat "$work/err")"
refuses "the cameras are swapped" $(cameras --left "$data/right0[1-5].jpg" --right "$data/left0[1-5].jpg")
refuses "--left has 13 files and --right 9" $(cameras --left "$data/left[01]?.jpg" --right "$data/right0?.jpg")
refuses "is its unit another one?" $(of_board 9x6 0.000025 --left $data/left0[1-5].jpg --right $data/right0[1-5].jpg)
ends_with 1 "of 1 pairs, 0 show the whole board" $(of_board 7x7 0.025 --left $data/left01.jpg --right $data/right01.jpg)
ends_with 1 "of 1 pairs, 1 show the whole board" $(cameras --left $data/left01.jpg --right $data/right01.jpg)
cp $data/left01.jpg $data/chessboard.png "$work/mixed"
refuses "images of one size" $(cameras --left "$work/mixed" --right "$data/right0[12].jpg")
set +f
mkdir "$work/l" "$work/r"
cp $data/left0[1-5].jpg $data/left{07,09,11,12}.jpg "$work/l"
cp $data/right0[1-5].jpg $data/right{08,09,11,12}.jpg "$work/r"
$(cameras --left "$work/l" --right "$work/r") >"$work/out" 2>"$work/err"
grep -q "left07.jpg and .*right08.jpg: are taken as a pair, but their numbers differ" "$work/err" || fail "other numbers: $(cat "$work/err")"
grep -q "left07.jpg and .*right08.jpg: fit far worse" "$work/err" || fail "a pair that is none: $(cat "$work/err")"
exit $failed
