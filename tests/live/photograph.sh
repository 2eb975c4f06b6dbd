#!/usr/bin/env bash
# A real stereo photograph, recorded by lcm-logger from multireach-camera, through the whole loop: the pink solid is seen within
# its own range of true depth (1.876 to 1.930 m, 5 % to 95 %; tools/moebius_test computes it from the true disparity).
bin=$1
timed=yes
. "$(dirname "$0")/namespace.sh"
. "$root/tools/recorder.sh"
photographs="$root/../shared/data/moebius"
[ -d "$photographs" ] || { echo "skipped: the pair of shared/data/moebius is not here"; exit 77; }
[ "$bin" -ef "$root/build/release/bin" ] || { echo "skipped: launch.sh runs the release build"; exit 77; }
lcm-logger --lcm-url='udpm://239.255.76.68:7668?ttl=0&recv_buf_size=4194304' --force --quiet "$work/session.lcm" & logger=$!
sleep 0.5
"$bin/multireach-camera" images --left "$photographs/view1.png" --right "$photographs/view5.png" --repeat 60 2>/dev/null || failed "camera"
await_written "$work/session.lcm"; kill -INT $logger; wait $logger 2>/dev/null
cp "$root/tests/data/moebius/vision.yaml" "$work/session.vision.yaml"
"$root/tools/launch.sh" --no-setup --session "$work/session.lcm" --json "$work/report.json" 2>"$work/err"
code=$?  # the arm does not reach the solid
{ [ $code -eq 1 ] && grep -q "none of the 1 positions is within the arm's reach" "$work/err"; } || failed "exit code $code: $(cat "$work/err")"
depth=$(tr -d ' \n' <"$work/report.json" | grep -o '"unreachable":.*"target_m":\[[^]]*\]' | grep -o '[0-9.e-]*\]' | tr -d ']' | tail -n1)
awk -v z="$depth" 'BEGIN { exit !(z > 1.876 && z < 1.930) }' || failed "the solid is seen at a depth of '$depth' m"
finish
