#!/usr/bin/env bash
# Seeded faults of the running system, in turn with the simulated Hoap2 and with drivers and emulators of a UR5e and an SO-101: real
# processes stopped, killed and restarted, foreign senders, malformed datagrams, an arm that is pushed or collides.
#   tests/full/live_faults.sh BIN [RUNS] [FIRST]     default 200 runs, the seeds FIRST = 1, 2, ...
# In each run: the commands keep the limits of position, speed by time of arrival, acceleration and jerk by message time; then the
# bridge runs again by itself, or is in a fault that names its cause and ends by a reset.
bin=$1 runs=${2:-200} first=${3:-1}
. "$(dirname "$0")/../live/namespace.sh"
. "$root/tests/live/streams.sh"
arms=(hoap2 ur5e hoap2 so101)
url='udpm://239.255.76.67:7667?ttl=0'
declare -A pids
# run NAME FILE [OPTION...]
run() { local name=$1 file=$2; shift 2; "$bin/multireach-$name" --config "$file" "$@" 2>"$work/$name.err" & pids[$name]=$!; }
start() {
  case "$1" in
    vision) run vision "$folder/vision.yaml" ;;
    robot-driver) run robot-driver "$robot" --simulated --device "$work/serial" ;;
    robot-emulator) run robot-emulator "$robot" --device "$work/serial" ;;
    *) run "$1" "$robot" ;;
  esac
}
status() { "$bin/multireach-robot" status 2>&1; }
pause() { sleep "$(awk -v ms="$1" 'BEGIN { print ms / 1000 }')"; }
numbers() { tr -d ' \n' <"$1" | grep -o "\"$2\":[0-9.e+-]*" | cut -d: -f2; }

stall() {
  local names=() name
  for name in "${nodes[@]}" camera; do ((RANDOM % 2)) && names+=("$name"); done
  [ ${#names[@]} -gt 0 ] || names=(bridge)
  what="stopped ${names[*]} for $1 ms"
  for name in "${names[@]}"; do kill -STOP "${pids[$name]}"; done
  pause "$1"
  for name in "${names[@]}"; do kill -CONT "${pids[$name]}"; done
}
kill_one() {
  local name=${nodes[RANDOM % ${#nodes[@]}]}
  what="killed $name, started again after $1 ms"
  kill -KILL "${pids[$name]}"; wait "${pids[$name]}" 2>/dev/null
  pause "$1"
  start "$name"
}
foreign_log() {
  what="an old log for $1 ms"
  lcm-logplayer --lcm-url="$url" "$root/logs/load.lcm" >/dev/null 2>&1 & local player=$!
  pause "$1"
  kill $player 2>/dev/null; wait $player 2>/dev/null
}
second_pipeline() {
  what="a second controller and bridge for $1 ms"
  "$bin/multireach-controller" --config "$robot" 2>/dev/null & local other=$!
  "$bin/multireach-bridge" --config "$robot" 2>/dev/null & local bridge=$!
  pause "$1"
  kill $other $bridge; wait $other $bridge 2>/dev/null
}
garbage() {
  what="malformed datagrams"
  "$bin/multireach-test-garbage" >/dev/null 2>&1
}
# The simulated arm is pushed a little; an emulated one takes it for a collision, and stops by itself.
push() {
  what="a push"
  "$bin/multireach-publish" perturbation "$(awk '/tip:/ { print $2 }' "$robot")" 0 25 0 --duration 0.05 >/dev/null 2>&1
}
fault() {
  local ms=$((20 + (RANDOM % 38) * (RANDOM % 38)))
  case $((RANDOM % 9)) in
    8) push ;;
    0 | 1 | 2) stall $ms ;;
    3 | 4) kill_one $ms ;;
    5) foreign_log $((ms + 300)) ;;
    6) second_pipeline $((ms + 300)) ;;
    *) garbage ;;
  esac
}

# Waits until the bridge follows a controller again; a fault must name its cause and end by a reset.
recovers() {
  local said
  for _ in $(seq 40); do
    said=$(status)
    case "$said" in
      *running*) return 0 ;;
      *"fault: "?*)  # a UR that was switched off waits for `enable`
        resets=$((resets + 1))
        "$bin/multireach-robot" enable >/dev/null 2>&1
        "$bin/multireach-robot" reset >/dev/null 2>&1 ;;
      *fault*) return 1 ;;
    esac
    sleep 0.2
  done
  return 1
}

reset_runs=0
readarray -t old < <(runs_in "$root/logs/load.lcm" "$root/robots/hoap2/robot.yaml")
for seed in $(seq "$first" $((first + runs - 1))); do
  RANDOM=$seed resets=0 said=()
  arm=${arms[seed % ${#arms[@]}]} folder=$root/robots/${arms[seed % ${#arms[@]}]}
  robot=$folder/robot.yaml scene=$folder/scene.yaml nodes=(vision controller bridge robot-sim)
  if [ "$arm" = hoap2 ]; then scene=$root/logs/reach.yaml; else nodes=(vision controller bridge robot-driver robot-emulator); fi
  for name in "${nodes[@]}"; do start "$name"; done
  "$bin/multireach-view" --robot "$robot" --wait-for "$(IFS=,; echo "${nodes[*]//-/_}")" --seconds 10 2>/dev/null || failed "seed $seed: the nodes did not start"
  if [ "$arm" != hoap2 ]; then
    for _ in $(seq 150); do grep -q 'the robot: ready' "$work/robot-driver.err" && break; sleep 0.1; done
  fi
  LD_PRELOAD="$bin/libmultireach-datagram-guard.so" chrt --fifo 10 lcm-logger --lcm-url="$url&recv_buf_size=4194304" --force --quiet "$work/run.lcm" 2>/dev/null & logger=$!
  "$bin/multireach-camera" render --config "$scene" --seconds 20 2>/dev/null & pids[camera]=$!
  pause $((1200 + RANDOM % 800))
  for _ in $(seq $((1 + RANDOM % 2))); do fault; said+=("$what"); pause $((RANDOM % 500)); done
  recovers || failed "seed $seed (${said[*]}): does not run again: $(status)"
  sleep 0.3
  for name in camera "${nodes[@]}"; do kill "${pids[$name]}" 2>/dev/null; wait "${pids[$name]}" 2>/dev/null; done
  kill -INT $logger; wait $logger 2>/dev/null
  "$bin/multireach-log" report "$work/run.lcm" --robot "$robot" --json "$work/report.json" >/dev/null 2>&1
  for limit in speed:1.06 acceleration:1.0001 jerk:1.0001; do
    share=$(largest_share command_streams "${limit%:*}" "$work/report.json" "${old[@]}")
    awk -v share="$share" -v most="${limit#*:}" 'BEGIN { exit !(share != "" && share <= most) }' ||
      failed "seed $seed (${said[*]}): ${limit%:*} of the commands $share of the limit"
  done
  share=$(largest_share robot_streams speed "$work/report.json" "${old[@]}")
  # What pushes an arm may move it faster.
  [[ ${said[*]} == *"a push"* ]] || awk -v share="$share" 'BEGIN { exit !(share != "" && share <= 1.06) }' || failed "seed $seed (${said[*]}): the robot moved at $share of its speed limit"
  awk -v excess="$(numbers "$work/report.json" max_limit_violation_rad)" 'BEGIN { exit !(excess <= 1e-9) }' || failed "seed $seed (${said[*]}): beyond a position limit"
  [ $resets -eq 0 ] || reset_runs=$((reset_runs + 1))
  echo "seed $seed, $arm: ${said[*]}; resets $resets"
done
echo "$runs runs, $reset_runs of them with a fault that was reset, $failures failures"
finish
