#!/usr/bin/env bash
# Stalled and foreign processes: the commands keep the speed limit by arrival time, a second sender moves nothing, and the motion
# resumes by itself. Prints a table of docs/safety.md.
bin=$1
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
  chrt --fifo 10 lcm-logger --lcm-url='udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304' --force --quiet "$work/control.lcm" & logger=$!
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
echo "| what happened | speed of the commands, % of the limit | of the robot | positions reached |"
echo "|---|---|---|---|"
# end WHAT_HAPPENED: ends all processes, measures the recording and prints its row.
end() {
  for name in camera vision controller bridge robot-sim; do kill "${pids[$name]}" 2>/dev/null; wait "${pids[$name]}" 2>/dev/null; done
  kill -INT $logger; wait $logger 2>/dev/null
  "$bin/multireach-log" report "$work/control.lcm" --robot "$robot" --json "$work/report.json" >/dev/null 2>"$work/report.err"
  speed=$(largest_share command_streams speed "$work/report.json" "${old[@]}") robot_speed=$(largest_share robot_streams speed "$work/report.json" "${old[@]}")
  reached=$(tr -d ' \n' <"$work/report.json" | grep -o '"settle_s":[0-9]' | wc -l)
  awk -v what="$1" -v speed="$speed" -v robot="$robot_speed" -v reached="$reached" 'BEGIN { printf "| %s | %.0f | %.0f | %d |\n", what, 100 * speed, 100 * robot, reached }'
  awk -v speed="$speed" 'BEGIN { exit !(speed > 0 && speed <= 1.06) }' || failed "$1: the commands move at $speed of the speed limit"
  awk -v speed="$robot_speed" 'BEGIN { exit !(speed > 0 && speed <= 1.06) }' || failed "$1: the robot moves at $robot_speed of the speed limit"
}
readarray -t old < <(runs_in "$root/logs/load.lcm" "$robot")

begin; signal STOP vision controller bridge robot-sim camera; sleep 1; signal CONT vision controller bridge robot-sim camera
resumes "after a stop of all processes"
end "all processes stopped for 1 s (SIGSTOP)"
begin; signal STOP bridge; sleep 0.7; signal CONT bridge
resumes "after a stop of the bridge"
end "the bridge alone stopped for 0.7 s"
begin; signal STOP controller; sleep 2; signal CONT controller
resumes "after a stop of the controller"
end "the controller stopped for 2 s"
begin; signal STOP robot-sim; sleep 1.5; signal CONT robot-sim
await "fault: " "a robot that was gone"
"$bin/multireach-robot" reset >"$work/out" 2>&1 || failed "reset: $(cat "$work/out")"
resumes "after the reset"
end "the simulated robot stopped for 1.5 s: a fault, which is reset"
begin; kill -KILL "${pids[controller]}"; wait "${pids[controller]}" 2>/dev/null; run controller "$robot"
resumes "after a restart of the controller"
end "the controller killed and restarted"
begin
lcm-logplayer --lcm-url='udpm://239.255.76.67:7667?ttl=0' "$root/logs/load.lcm" >/dev/null 2>&1 & player=$!
sleep 3; "$bin/multireach-replay" play --lockstep "$root/logs/reach.lcm" >/dev/null 2>&1 & lockstep=$!
sleep 2; await running "beside an old log"
kill $player $lockstep 2>/dev/null; wait $player $lockstep 2>/dev/null
end "an old log by \`lcm-logplayer\`, then \`play --lockstep\`, beside it"
finish
