#!/usr/bin/env bash
# The whole system for an hour: memory stays flat, no message is lost, every limit is kept.
#   tests/full/soak.sh BIN [SECONDS]     default 3600, at least 300
# Prints, for each process, the resident memory after a minute and at the end. A leak of one 16-byte block (what malloc gives
# for less) in each message would show: the rarest, NODE_STATUS apart, come 20 times a second, so 1.1 MB an hour.
bin=$1 seconds=${2:-3600}
. "$(dirname "$0")/../live/namespace.sh"
robot="$root/robots/hoap2/robot.yaml"
awk -v end="$seconds" -v vision="$root/robots/hoap2/vision.yaml" 'BEGIN {
  printf "vision: %s\ntarget_name: ball\nseed: 1\nrate_hz: 30\nend_s: %d\norigin_utime: 1200096000000000\njpeg_quality: 68\npath:\n", vision, end
  split("0.10, -0.12, 0.10|0.10, -0.05, 0.02|0.05, -0.22, 0.10|0.12, -0.17, 0.02|0.24, -0.10, 0.05", at, "|")
  print "  - {at_s: 0, position_m: [" at[1] "]}"
  for (k = 1; 5 * k + 1 < end; ++k) print "  - {at_s: " 5 * k ", move_to_m: [" at[k % 5 + 1] "], over_s: 0.8}"
}' >"$work/scene.yaml"

url='udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304'
declare -A pids first
LD_PRELOAD="$bin/libmultireach-datagram-guard.so" lcm-logger --lcm-url="$url" --force --quiet "$work/run.lcm" & logger=$!
"$bin/multireach-vision" --config "$root/robots/hoap2/vision.yaml" 2>"$work/vision.err" & pids[vision]=$!
for node in controller bridge robot-sim; do "$bin/multireach-$node" --config "$robot" 2>"$work/$node.err" & pids[$node]=$!; done
"$bin/multireach-view" --robot "$robot" --wait-for vision,controller,bridge,robot_sim --seconds 8 2>/dev/null || failed "the nodes did not start"
"$bin/multireach-camera" render --config "$work/scene.yaml" 2>"$work/camera.err" & pids[camera]=$!

resident_kb() { awk '/^VmRSS/ { print $2 }' "/proc/$1/status"; }
sleep 60
for node in "${!pids[@]}"; do first[$node]=$(resident_kb "${pids[$node]}"); done
sleep $((seconds - 75))
for node in "${!pids[@]}"; do
  last=$(resident_kb "${pids[$node]}") || { failed "$node ended: $(tail -n 2 "$work/$node.err")"; continue; }
  echo "$node: ${first[$node]} kB after a minute, $last kB at the end"
  [ $((last - first[$node])) -lt $((1100 * seconds / 3600 + 100)) ] || failed "the memory of $node grows"
done
wait "${pids[camera]}" || failed "the camera: $(tail -n 2 "$work/camera.err")"
"$bin/multireach-robot" status
for node in vision controller bridge robot-sim; do kill -INT "${pids[$node]}"; wait "${pids[$node]}" || failed "$node: exit code $?"; done
kill -INT $logger; wait $logger
"$bin/multireach-log" report "$work/run.lcm" --robot "$robot" --json "$work/report.json" >"$work/report.txt" 2>&1
cat "$work/report.txt"
number() { tr -d ' \n' <"$work/report.json" | grep -o "\"$1\":[^,}]*" | head -n1 | cut -d: -f2; }
for count in lcm_lost refused damaged; do [ "$(number $count)" = 0 ] || failed "$count: $(number $count)"; done
awk -v a="$(number max_limit_violation_rad)" 'BEGIN { exit !(a == 0) }' || failed "beyond a position limit by $(number max_limit_violation_rad)"
[ $failures -eq 0 ] || { cp "$work"/*.err "$work/run.lcm" "$work/report.json" "$(mktemp -d /tmp/multireach-soak-XXXX)"; echo "the recording is kept in /tmp/multireach-soak-*"; }
finish
