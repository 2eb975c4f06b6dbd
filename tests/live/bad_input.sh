#!/usr/bin/env bash
# Programs given bad input say one sentence that names it, and exit with 2 (wrong usage or input) or 1 (did not succeed).
bin=$1
. "$(dirname "$0")/namespace.sh"
urdf="$root/robots/hoap2/hoap2.urdf"

# expect CODE 'words that the sentence has' COMMAND...
expect() {
  local code=$1 words=$2; shift 2
  timeout 20 "$@" >"$work/out" 2>"$work/err"
  local got=$?
  [ $got -eq "$code" ] || failed "exit code $got, expected $code: $*"
  grep -qF -- "$words" "$work/err" || failed "no '$words' in '$(cat "$work/err")': $*"
  [ "$(grep -cE '^(multireach-[a-z-]*|launch.sh): ' "$work/err")" -eq 1 ] || failed "not one sentence: $(cat "$work/err"): $*"
}
trace() { echo "$bin/multireach-trace" --base torso --steps 10 --gamma 350 "$@"; }

expect 2 "nowhere.urdf: cannot be opened" $(trace --urdf nowhere.urdf --tip right_hand --start=0,0,0,0 --target=0,0,0)
expect 2 "is not a valid URDF" $(trace --urdf "$root/README.md" --tip right_hand --start=0,0,0,0 --target=0,0,0)
expect 2 "no link 'foot'" $(trace --urdf "$urdf" --tip foot --start=0,0,0,0 --target=0,0,0)
expect 2 "4 joints" $(trace --urdf "$urdf" --tip right_hand --start=0,0,0 --target=0.1,-0.1,0)
expect 2 "right_SAA" $(trace --urdf "$urdf" --tip right_hand --start=0,1,0,0 --target=0.1,-0.1,0)
expect 2 "right_EB" $(trace --urdf "$urdf" --tip right_hand --start=0,0,0,nan --target=0.1,-0.1,0)
expect 2 "--target-posture: joint 'right_SFE'" $(trace --urdf "$urdf" --tip right_hand --start=0,0,0,0 --target=0.1,-0.1,0 --target-posture=2,0,0,0)
expect 2 "'x' is not a number" $(trace --urdf "$urdf" --tip right_hand --start=0,x,0,0 --target=0.1,-0.1,0)
expect 2 "not a finite number" $(trace --urdf "$urdf" --tip right_hand --start=0,0,0,0 --target=inf,0,0)
expect 2 "expected x,y,z" $(trace --urdf "$urdf" --tip right_hand --start=0,0,0,0 --target=0,0)
expect 1 "no posture inside the limits" $(trace --urdf "$urdf" --tip right_hand --start=0,0,0,0 --target=1,0,0)
expect 2 "--help" "$bin/multireach-trace" --no-such-option

expect 2 "nothing.yaml: cannot be opened" "$bin/multireach-controller" --config nothing.yaml
sed 's/alpha_per_step/alpa/' "$root/robots/hoap2/robot.yaml" >"$work/robot.yaml"
cp "$urdf" "$work"
expect 2 "key 'controller.alpa' is not known" "$bin/multireach-controller" --config "$work/robot.yaml"
sed 's/tip: right_hand/tip: hand/' "$root/robots/hoap2/robot.yaml" >"$work/robot.yaml"
expect 2 "key 'robot.tip' is 'hand'; expected a link of" "$bin/multireach-bridge" --config "$work/robot.yaml"
sed 's/right_SFE: 0.2/right_nose: 0.2/' "$root/robots/hoap2/robot.yaml" >"$work/robot.yaml"
expect 2 "right_nose" "$bin/multireach-robot-sim" --config "$work/robot.yaml"

vision="$root/robots/hoap2/vision.yaml"
sed 's/-0.0601/0.0601/' "$vision" >"$work/vision.yaml"
expect 2 "baseline's sign is wrong" "$bin/multireach-vision" --config "$work/vision.yaml"
sed 's/fx_px: 300/fx_px: many/' "$vision" >"$work/vision.yaml"
expect 2 "'cameras.left.fx_px' is 'many'" "$bin/multireach-vision" --config "$work/vision.yaml"
expect 2 "is not an image" "$bin/multireach-vision" --config "$vision" --pair "$vision" "$vision"
expect 2 "none.png: cannot be opened" "$bin/multireach-vision" --config "$vision" --pair none.png none.png
printf 'P6\n2 2\n255\n123456789012' >"$work/small.ppm"
expect 2 "the calibration is for 320 x 240" "$bin/multireach-vision" --config "$vision" --pair "$work/small.ppm" "$work/small.ppm"

expect 2 "no file matches" "$bin/multireach-camera" images --left nothing --right nothing
expect 2 "neither a camera device nor a video" "$bin/multireach-camera" device --left 77 --right 78
sed 's/noise_grey_levels/noise/; s|\.\./robots|'"$root"'/robots|' "$root/logs/reach.yaml" >"$work/scene.yaml"
expect 2 "key 'noise' is not known" "$bin/multireach-camera" render --config "$work/scene.yaml"
expect 2 "nothing.lcm: cannot be opened" "$bin/multireach-log" info nothing.lcm
expect 1 "no event was selected" "$bin/multireach-log" filter "$root/logs/reach.lcm" -o "$work/none.lcm" --channel NOTHING
expect 2 "cannot be written over" "$bin/multireach-log" cut "$work/none.lcm" -o "$work/none.lcm"
expect 2 "holds no event of an LCM log" "$bin/multireach-log" report "$root/README.md" --robot "$root/robots/hoap2/robot.yaml"

expect 1 "standard output: cannot be written" bash -c '"$1" --config-reference >/dev/full' - "$bin/multireach-controller"

# What is no regular file of a bounded size is refused at once.
mkfifo "$work/pipe"
truncate --size 10G "$work/large"
for file in /dev/zero "$work/pipe"; do
  expect 2 "$file: is a device or a pipe" "$bin/multireach-controller" --config "$file"
  expect 2 "$file: is a device or a pipe" "$bin/multireach-vision" --config "$file"
  expect 2 "$file: is a device or a pipe" "$bin/multireach-vision" --config "$vision" --pair "$file" "$file"
  expect 2 "$file: is a device or a pipe" "$bin/multireach-log" info "$file"
  expect 2 "$file: is a device or a pipe" $(trace --urdf "$file" --tip right_hand --start=0,0,0,0 --target=0,0,0)
done
expect 2 "at most 16 MB" "$bin/multireach-controller" --config "$work/large"
expect 2 "at most 1024 MB" "$bin/multireach-vision" --config "$vision" --pair "$work/large" "$work/large"
expect 2 "no event of an LCM log in its first 256 MB" "$bin/multireach-log" check "$work/large"

# A full disk, and a file that cannot become as large: said, and nothing incomplete is left.
log="$root/logs/reach.lcm" robot="$root/robots/hoap2/robot.yaml"
limited() { trap '' XFSZ; ulimit -f 8; "$@"; }
export -f limited
"$bin/multireach-replay" run "$log" --until 1 -o "$work/run.lcm" >/dev/null 2>&1
rm -rf "$work/full"; mkdir "$work/full"
for format in mat mcap csv; do
  expect 1 "cannot be written (File too large)" bash -c 'limited "$@"' - "$bin/multireach-log" export $format "$work/run.lcm" -o "$work/full/run.$format"
done
expect 1 "cannot be written (File too large)" bash -c 'limited "$@"' - "$bin/multireach-log" merge "$work/run.lcm" -o "$work/full/merged.lcm"
expect 1 "cannot be written (File too large)" bash -c 'limited "$@"' - "$bin/multireach-replay" run "$log" --until 1 -o "$work/full/replayed.lcm"
[ -z "$(find "$work/full" -type f)" ] || failed "incomplete files are left: $(find "$work/full" -type f)"
for format in mat mcap; do
  expect 1 "/dev/full: cannot be written (No space left on device)" "$bin/multireach-log" export $format "$work/run.lcm" -o /dev/full
done
for report in "multireach-log info $work/run.lcm" "multireach-log latency $work/run.lcm" "multireach-replay run $log --until 1"; do
  expect 1 "/dev/full: cannot be written" "$bin"/$report --json /dev/full
  expect 1 "standard output: cannot be written" bash -c '"$@" >/dev/full' - "$bin"/$report
done
expect 1 "/dev/full: cannot be written" "$bin/multireach-study" --urdf "$urdf" --base torso --tip right_hand --samples 10 --csv /dev/full
expect 1 "/dev/full: cannot be written" $(trace --urdf "$urdf" --tip right_hand --law paper --start=0.2,-0.3,-0.2,-0.9 --target=0.1,-0.12,0.1 -o /dev/full)
expect 1 "standard output: cannot be written" bash -c '"$@" >/dev/full' - $(trace --urdf "$urdf" --tip right_hand --law paper --start=0.2,-0.3,-0.2,-0.9 --target=0.1,-0.12,0.1)

# Signals leave no temporary file.
for signal in INT TERM; do
  env --default-signal=INT "$bin/multireach-replay" run "$log" --until 1e9 -o "$work/full/run.lcm" >/dev/null 2>&1 & running=$!
  for _ in $(seq 100); do [ -n "$(find "$work/full" -type f)" ] && break; sleep 0.02; done
  [ -n "$(find "$work/full" -type f)" ] || failed "the replay ended before signal $signal"
  kill -$signal $running
  wait $running
  [ $? -gt 128 ] || failed "the replay succeeded in spite of signal $signal"
  [ -z "$(find "$work/full" -type f)" ] || failed "after $signal are left: $(find "$work/full" -type f)"
done

expect 2 "cannot be read" "$root/tools/launch.sh" --no-setup --session nothing.lcm
expect 2 "holds no event of an LCM log" "$root/tools/launch.sh" --no-setup --session "$root/README.md"
expect 2 "its folder does not exist" "$root/tools/launch.sh" --no-setup --record /nonexist/run.lcm
expect 2 "'nan' is not a finite number" $(trace --urdf "$urdf" --tip right_hand --start=0,0,0,0 --target=0.1,-0.1,0 --alpha nan)
expect 2 "has no robot.yaml" "$root/tools/launch.sh" --no-setup --robot "$work/none"
expect 2 "unknown option" "$root/tools/launch.sh" --faster

# Without a route for multicast: one sentence, with the fix.
ip route del 224.0.0.0/4 dev lo
expect 2 "ip route add 224.0.0.0/4 dev lo" "$bin/multireach-controller" --config "$root/robots/hoap2/robot.yaml" --seconds 1
finish
