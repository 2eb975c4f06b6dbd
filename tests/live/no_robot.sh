#!/usr/bin/env bash
# multireach-robot tells a bridge whose robot is there from one whose robot is silent, and a controller that is there from one that is not.
bin=$1
. "$(dirname "$0")/namespace.sh"
robot="$root/robots/hoap2/robot.yaml"
"$bin/multireach-bridge" --config "$robot" --seconds 90 2>"$work/bridge.err" & bridge=$!
asks() {
  "$bin/multireach-robot" "$2" >"$work/out" 2>"$work/err"
  local code=$?
  [ $code -eq "$1" ] || failed "$2: exit code $code, expected $1: $(cat "$work/out" "$work/err")"
}
silent() { grep -q "no ROBOT_STATE arrives" "$work/err" || failed "$1 does not say that the robot is silent: $(cat "$work/err")"; }
asks 1 enable; silent "enable without a robot"
asks 0 stop
"$bin/multireach-robot-sim" --config "$robot" 2>"$work/sim.err" & sim=$!
for _ in $(seq 50); do "$bin/multireach-robot" enable >/dev/null 2>&1 && break; sleep 0.1; done
asks 0 enable
kill -STOP $sim
asks 1 enable; silent "enable with a stopped robot"
asks 0 status; silent "status with a stopped robot"
# Two lines: the bridge's state, alone in the first one, for scripts; then the controller's.
two_lines() {
  mapfile -t lines <"$work/out"
  [[ ${#lines[@]} = 2 && ${lines[0]} =~ ^[a-z]+(:.*)?,\ speed\ [0-9]+\ %,\ path\ rate\ [0-9]+\ %$ && ${lines[1]} =~ ^controller:\ $1 ]] ||
    failed "status does not say '$1' in its second line: $(cat "$work/out")"
}
two_lines 'not heard in [2-9]\.[0-9] s$'
# A script may read the first line only, and end its pipe before the second one comes.
(set -o pipefail; "$bin/multireach-robot" status | grep -q '^idle\|^armed\|^fault') || failed "status fails where only its first line is read"
kill -CONT $sim
"$bin/multireach-controller" --config "$robot" --seconds 90 2>"$work/controller.err" & controller=$!
"$bin/multireach-view" --robot "$robot" --wait-for controller --seconds 30 2>/dev/null || failed "the controller did not start"
asks 0 status; two_lines "waiting for (the robot|a target)$"
[ ! -s "$work/err" ] || failed "status with a robot that is there: $(cat "$work/err")"
"$bin/multireach-publish" target 0.1 -0.12 0.1 --robot "$robot" 2>/dev/null & publisher=$!
for _ in $(seq 50); do [[ $("$bin/multireach-robot" status) = *mm* ]] && break; done
asks 0 status; two_lines 'reaching, hand [0-9.]+ mm from the target$'
kill -KILL $publisher $controller
wait $publisher $controller 2>/dev/null
kill -KILL $sim $bridge
wait $sim $bridge 2>/dev/null
finish
