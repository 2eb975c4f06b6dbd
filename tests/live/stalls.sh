#!/usr/bin/env bash
# Stalled, foreign and broken processes: the commands keep the speed limit by arrival time, a second sender moves nothing, and the motion
# resumes by itself or after a reset. Prints a table of docs/safety.md; with --all, the whole of it, some seven minutes.
bin=$1 all=${2:-}
timed=yes
. "$(dirname "$0")/namespace.sh"
. "$root/tests/live/streams.sh"
robot="$root/robots/hoap2/robot.yaml"
declare -A pids
run() { "$bin/multireach-$1" --config "$2" 2>"$work/$1.err" & pids[$1]=$!; }
signal() { local s=$1; shift; for name in "$@"; do kill -"$s" "${pids[$name]}"; done; }
begin() {
  run vision "$root/robots/hoap2/vision.yaml"
  for node in controller bridge robot-sim; do run $node "$robot"; done
  "$bin/multireach-view" --robot "$robot" --wait-for vision,controller,bridge,robot_sim --seconds 30 2>/dev/null || failed "the nodes did not start"
  LD_PRELOAD="$bin/libmultireach-datagram-guard.so" chrt --fifo 10 lcm-logger --lcm-url='udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304' --force --quiet "$work/control.lcm" & logger=$!
  "$bin/multireach-camera" render --config "$root/logs/reach.yaml" 2>/dev/null & pids[camera]=$!
  await running "at first"
  sleep 0.5
}
status() { "$bin/multireach-robot" status 2>&1; }
# await STATE WHEN: until the bridge is in this state.
await() {
  local _ state=""
  for _ in $(seq 60); do
    state=$(status)
    [[ $state == *"$1"* ]] && return
    sleep 0.2
  done
  failed "$2: the bridge is not '$1': $state"
}
# resumes WHEN: the motion goes on, and is still going on two seconds later.
resumes() { sleep 1; await running "$1"; sleep 2; await running "$1"; }
# faults: waits until the bridge is in one, says which, and resets it.
faults() {
  await "fault: " "$1"
  fault=$(status | head -n1); fault=${fault%%, speed*} fault=" A fault, which is reset: ${fault#fault: }"
  for _ in $(seq 20); do
    sleep 0.3
    "$bin/multireach-robot" reset >"$work/out" 2>&1 && return
  done
  failed "$1: reset: $(cat "$work/out")"
}
fault=""
echo "| what happened | speed of the commands, % of the limit | of the robot | in the first versions, commands / robot | acceleration of the commands, % | positions reached |"
echo "|---|---|---|---|---|---|"
# end WHAT_HAPPENED [BEFORE [MOVED]]: ends all processes, measures the recording and prints its row. BEFORE: what the first versions did;
# MOVED: something else than its commands moved the robot.
end() {
  for name in camera vision controller bridge robot-sim; do kill "${pids[$name]}" 2>/dev/null; wait "${pids[$name]}" 2>/dev/null; done
  kill -INT $logger; wait $logger 2>/dev/null
  "$bin/multireach-log" report "$work/control.lcm" --robot "$robot" --json "$work/report.json" >/dev/null 2>"$work/report.err"
  speed=$(largest_share command_streams speed "$work/report.json" "${old[@]}") robot_speed=$(largest_share robot_streams speed "$work/report.json" "${old[@]}")
  reached=$(tr -d ' \n' <"$work/report.json" | grep -o '"settle_s":[0-9]' | wc -l)
  acceleration=$(largest_share command_streams acceleration "$work/report.json" "${old[@]}")
  awk -v what="$1.$fault" -v speed="$speed" -v robot="$robot_speed" -v reached="$reached" -v before="${2:-not tried}" -v acceleration="$acceleration" \
    'BEGIN { printf "| %s | %.0f | %.0f | %s | %.0f | %d |\n", what, 100 * speed, 100 * robot, before, 100 * acceleration, reached }'
  fault=""
  # Where nothing moved, the machine may have been late; above a limit, the bridge is wrong.
  awk -v share="$acceleration" 'BEGIN { exit !(share > 0) }' || failed "$1: the commands accelerate at '$acceleration' of the limit"
  awk -v share="$acceleration" 'BEGIN { exit !(share <= 1.0001) }' || wrong "$1: the commands accelerate at $acceleration of the limit"
  awk -v speed="$speed" 'BEGIN { exit !(speed > 0) }' || failed "$1: the commands move at '$speed' of the speed limit"
  awk -v speed="$speed" 'BEGIN { exit !(speed <= 1.06) }' || wrong "$1: the commands move at $speed of the speed limit"
  [ -n "${3:-}" ] || awk -v speed="$robot_speed" 'BEGIN { exit !(speed > 0 && speed <= 1.06) }' || failed "$1: the robot moves at $robot_speed of the speed limit"
}
readarray -t old < <(runs_in "$root/logs/load.lcm" "$robot")

begin; signal STOP vision controller bridge robot-sim camera; sleep 1; signal CONT vision controller bridge robot-sim camera
resumes "after a stop of all processes"
end "All processes stopped for 1 s (SIGSTOP)" "330 to 600 / 430 to 1270"
begin; signal STOP bridge; sleep 0.7; signal CONT bridge
resumes "after a stop of the bridge"
end "The bridge stopped for 0.7 s" "150 to 580 / 170 to 470"
begin; signal STOP controller; sleep 2; signal CONT controller
resumes "after a stop of the controller"
end "The controller stopped for 2 s"
begin; signal STOP robot-sim; sleep 1.5; signal CONT robot-sim
faults "a robot that was gone"
resumes "after the reset"
end "The simulated robot stopped for 1.5 s" "goes on / 980"
begin; kill -KILL "${pids[controller]}"; wait "${pids[controller]}" 2>/dev/null; run controller "$robot"
resumes "after a restart of the controller"
end "The controller killed and restarted"
begin
lcm-logplayer --lcm-url='udpm://239.255.76.67:7667?ttl=0' "$root/logs/load.lcm" >/dev/null 2>&1 & player=$!
sleep 3; "$bin/multireach-replay" play --lockstep "$root/logs/reach.lcm" >/dev/null 2>&1 & lockstep=$!
sleep 2; await running "beside an old log"
kill $player $lockstep 2>/dev/null; wait $player $lockstep 2>/dev/null
end "An old log by \`lcm-logplayer\`, then \`play --lockstep\`, beside it" "680 / 2250"
[ "$all" = --all ] || finish

for name in vision camera; do
  begin; signal STOP $name; sleep 1.5; signal CONT $name
  resumes "after a stop: $name"
  end "${name^} stopped for 1.5 s" "150 to 580 / 170 to 470"
done
begin; signal STOP controller; sleep 5; signal CONT controller
resumes "after a long stop of the controller"
end "The controller stopped for 5 s" "600 / 520"
begin; signal STOP controller; sleep 0.06; signal CONT controller
resumes "after a late set-point"
end "The controller stopped for 60 ms: one set-point is missing" "speed kept; acceleration 10 000"
begin; "$bin/multireach-test-forger" setpoints 1
resumes "after a forged set-point"
end "One far set-point 0.95 s in the future, in the controller's name" "370 / 580"
begin; "$bin/multireach-test-forger" setpoints 20
resumes "after forged set-points"
end "Twenty, each 0.95 s further" "1420 / 970"
begin; old+=("$("$bin/multireach-test-forger" commands 2)")
resumes "after forged commands"
end "A second publisher of \`JOINT_COMMAND\`, 1 kHz for 2 s" "2080 / 2130"
begin; kill -KILL "${pids[robot-sim]}"; wait "${pids[robot-sim]}" 2>/dev/null; run robot-sim "$robot"
faults "a robot that was restarted"
resumes "after the reset"
end "The robot restarted elsewhere" "goes on / 980"
begin; "$bin/multireach-publish" perturbation right_hand 0 150 0 --duration 2 >/dev/null 2>&1
faults "a robot that is pushed away"
resumes "after the reset"
end "The hand pushed by 150 N for 2 s" "goes on / not measured" pushed
begin; "$bin/multireach-test-garbage" >/dev/null 2>&1
resumes "after malformed datagrams"
end "Malformed datagrams, and garbled messages on all channels" "bridge, logger and view ended"
finish
