#!/usr/bin/env bash
# multireach-robot tells a bridge whose robot is there from one whose robot is silent.
bin=$1
. "$(dirname "$0")/namespace.sh"
robot="$root/robots/hoap2/robot.yaml"
"$bin/multireach-bridge" --config "$robot" --seconds 30 2>"$work/bridge.err" & bridge=$!
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
asks 0 status
kill -KILL $sim $bridge
wait $sim $bridge 2>/dev/null
finish
