#!/usr/bin/env bash
# Each driver with its emulator as processes: the arm reaches what the rendered cameras see, and the emulated robot refuses nothing.
# After a collision the robot stops by itself, the bridge is in a fault, and the documented commands lead back. MULTIREACH_DRIVERS names
# the arms; by default one for each driver, and `tools/test.sh --full` has the others.
bin=$1
timed=yes
. "$(dirname "$0")/namespace.sh"
declare -A pids
run() { local name=$1; shift; "$@" 2>"$work/$name.err" & pids[$name]=$!; }
end() { for name in "$@"; do kill "${pids[$name]}" 2>/dev/null; wait "${pids[$name]}" 2>/dev/null; done; }
status() { "$bin/multireach-robot" status 2>&1; }
# ask WORD: until the bridge accepts, for 15 s.
ask() { for _ in $(seq 30); do "$bin/multireach-robot" "$1" >"$work/$1.out" 2>&1 && return 0; sleep 0.5; done; return 1; }

urgent=()
chrt --fifo 42 true 2>/dev/null && urgent=(chrt --fifo 42)
# record LOG: above the priority of the nodes. The stream of a driver and its emulator besides the bridge's, each at 1 kHz, can keep two
# processors busy for 30 ms at a time; lcm-logger would read that late, stamp it all with nearly the same time, and lose some.
record() {
  LD_PRELOAD="$bin/libmultireach-datagram-guard.so" "${urgent[@]}" lcm-logger --lcm-url='udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304' --force --quiet "$1" & logger=$!
}

# last_speed LOG: of the fastest joint in the last ROBOT_STATE, rad/s.
last_speed() {
  rm -rf "$work/csv"
  "$bin/multireach-log" export csv "$1" -o "$work/csv" --channel ROBOT_STATE >/dev/null 2>&1
  awk -F, '
    NR == 1 { for (i = 1; i <= NF; ++i) if ($i ~ /^joint_velocity/) is[i] }
    NR > 1 { most = 0; for (i in is) { v = $i < 0 ? -$i : $i; if (v > most) most = v } }
    END { print most + 0 }' "$work/csv/ROBOT_STATE.csv"
}

# moving_scene FOLDER: its scene.yaml with a target that goes to and fro between two places of it, and never rests, for 60 s.
moving_scene() {
  awk '/^path:/ { exit } /^end_s:/ { $2 = 60 } { print }' "$1/scene.yaml"
  awk 'match($0, /move_to_m: \[[^]]*\]/) && places < 2 { place[places++] = substr($0, RSTART + 11, RLENGTH - 11) }
    END {
      print "path:\n  - {at_s: 0, position_m: " place[0] "}"
      for (at = 0; at < 60; at += 2) print "  - {at_s: " at ", move_to_m: " place[at / 2 % 2 ? 0 : 1] ", over_s: 2}"
    }' "$1/scene.yaml"
}

for arm in ${MULTIREACH_DRIVERS:-iiwa14 fr3 ur5e so101 so101_dynamixel}; do
  folder=$work/$arm
  cp -r "$root/robots/${arm%_dynamixel}" "$folder"
  [ "$arm" = "${arm%_dynamixel}" ] || sed -i 's/name: feetech/name: dynamixel/' "$folder/robot.yaml"
  run vision "$bin/multireach-vision" --config "$folder/vision.yaml"
  run controller "$bin/multireach-controller" --config "$folder"
  run bridge "$bin/multireach-bridge" --config "$folder"
  run emulator "$bin/multireach-robot-emulator" --config "$folder" --device "$work/serial"
  run driver "$bin/multireach-robot-driver" --config "$folder" --simulated --device "$work/serial"
  "$bin/multireach-view" --robot "$folder" --wait-for vision,controller,bridge,robot_emulator,robot_driver --seconds 30 2>/dev/null || failed "$arm: the nodes did not start"
  for _ in $(seq 150); do grep -q 'the robot: ready' "$work/driver.err" && break; sleep 0.1; done
  grep -q 'the robot: ready' "$work/driver.err" || failed "$arm: not ready: $(cat "$work/driver.err")"
  record "$work/control.lcm"
  "$bin/multireach-camera" render --config "$folder/scene.yaml" --seconds 8 2>/dev/null
  kill -INT $logger; wait $logger 2>/dev/null
  status | grep -q running || failed "$arm: $(status); $(cat "$work/driver.err")"
  grep -q 'has stopped' "$work/emulator.err" && failed "$arm: the emulated robot: $(cat "$work/emulator.err")"
  "$bin/multireach-log" report "$work/control.lcm" --robot "$folder" --json "$work/report.json" >"$work/table" 2>"$work/report.err" || failed "$arm: $(cat "$work/table" "$work/report.err")"
  [ "$(tr -d ' \n' <"$work/report.json" | grep -o '"settle_s":[0-9]' | wc -l)" -ge 2 ] || failed "$arm: less than two places reached: $(cat "$work/table")"

  "$bin/multireach-camera" render --config "$folder/scene.yaml" --seconds 16 2>/dev/null & pids[camera]=$!
  sleep 5
  link=$(awk '/tip:/ { print $2 }' "$folder/robot.yaml")
  "$bin/multireach-publish" perturbation "$link" 30 0 0 --duration 0.1 >"$work/out" 2>&1 || failed "$arm: $(cat "$work/out")"
  for _ in $(seq 40); do status | grep -q 'fault: ' && break; sleep 0.1; done
  status | grep -q 'fault: ' || failed "$arm: a robot that stopped is no fault: $(status)"
  grep -q 'has stopped' "$work/emulator.err" || failed "$arm: the emulated robot did not stop"
  case $(awk '/^driver:/ { found = 1 } found && /name:/ { print $2; exit }' "$folder/robot.yaml") in
    iiwa|panda) end emulator; run emulator "$bin/multireach-robot-emulator" --config "$folder" --device "$work/serial" ;;
  esac
  ask reset || failed "$arm: reset: $(cat "$work/reset.out"); $(cat "$work/driver.err")"
  for _ in $(seq 150); do status | grep -qE '^(armed|running)' && break; sleep 0.1; done
  status | grep -qE '^(armed|running)' || failed "$arm: after the reset: $(status); $(cat "$work/driver.err")"
  end camera
  # Ctrl-C reaches all processes at once: the driver brings the arm to standstill before it ends.
  for _ in $(seq 50); do status | grep -q '^armed' && break; sleep 0.1; done
  record "$work/end.lcm"
  moving_scene "$folder" >"$folder/moving.yaml"
  "$bin/multireach-camera" render --config "$folder/moving.yaml" 2>/dev/null & pids[camera]=$!
  for _ in $(seq 200); do before=$(last_speed "$work/end.lcm"); awk -v v="$before" 'BEGIN { exit !(v > 0.1) }' && break; sleep 0.05; done
  moving=$(status)
  kill -INT "${pids[driver]}" "${pids[bridge]}"
  for name in driver bridge; do wait "${pids[$name]}" || failed "$arm: the $name ended with $?"; done
  kill -INT $logger; wait $logger 2>/dev/null
  after=$(last_speed "$work/end.lcm")
  awk -v before="$before" -v after="$after" 'BEGIN { exit !(before > 0.1 && after < before / 2) }' ||
    failed "$arm: the driver ended at $after rad/s, before at $before rad/s; $moving"
  end camera emulator controller vision
done
finish
