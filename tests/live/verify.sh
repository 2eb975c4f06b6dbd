#!/usr/bin/env bash
# A live run under load, with a recorder that stops at times, a node that is killed and others that are stopped, is computed
# again message by message; and a byte that is changed is found.
bin=$1
. "$(dirname "$0")/namespace.sh"
. "$root/tools/recorder.sh"
robot="$root/robots/hoap2/robot.yaml"
declare -A pids
# Appends: to empty a file waits for the disk.
run() { "$bin/multireach-$1" --config "$2" 2>>"$work/$1.err" & pids[$1]=$!; }
lcm-logger --lcm-url='udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304' --force --quiet "$work/control.lcm" & control_logger=$!
lcm-logger --lcm-url='udpm://239.255.76.68:7668?ttl=0&recv_buf_size=4194304' --force --quiet "$work/images.lcm" & image_logger=$!
run vision "$root/robots/hoap2/vision.yaml"
for node in controller bridge robot-sim; do run $node "$robot"; done
"$bin/multireach-view" --robot "$robot" --wait-for vision,controller,bridge,robot_sim --seconds 30 2>/dev/null || failed "the nodes did not start"
load=()
for _ in 1 2 3 4; do sh -c 'while :; do :; done' & load+=($!); done
lcm-logplayer --lcm-url='udpm://239.255.76.68:7668?ttl=0' "$root/logs/reach.lcm" >/dev/null & player=$!
pause() { kill -STOP "$1"; sleep "$2"; kill -CONT "$1"; }
restart() { kill -KILL "${pids[$1]}"; wait "${pids[$1]}" 2>/dev/null; sleep 0.3; run "$1" "$2"; }
sleep 3; pause $control_logger 0.2
sleep 1; restart controller "$robot"
sleep 2; pause "${pids[bridge]}" 0.3
sleep 1; pause "${pids[vision]}" 0.4
sleep 1; restart bridge "$robot"
sleep 1; pause $control_logger 0.3
sleep 1; restart vision "$root/robots/hoap2/vision.yaml"
sleep 2; restart controller "$robot"
sleep 1; pause "${pids[robot-sim]}" 0.2
sleep 2; kill "${load[@]}" $player
for node in "${!pids[@]}"; do kill "${pids[$node]}"; wait "${pids[$node]}" || failed "$node, exit code $?: $(cat "$work/$node.err")"; done
await_written "$work"/{control,images}.lcm
kill -INT $control_logger $image_logger; wait $control_logger $image_logger 2>/dev/null
"$bin/multireach-log" merge "$work/control.lcm" "$work/images.lcm" --output "$work/live.lcm" || failed "the logs cannot be merged"
[ -z "${MULTIREACH_KEEP:-}" ] || cp "$work/live.lcm" "$MULTIREACH_KEEP"
"$bin/multireach-log" check "$work/live.lcm"
"$bin/multireach-replay" verify "$work/live.lcm" --json "$work/verify.json" | tee "$work/table" || failed "a difference: $(cat "$work/table")"
# Of the robot's states, one after each gap that the recorder left cannot be checked, and no other.
lost=$("$bin/multireach-log" info "$work/live.lcm" | awk '$1 == "ROBOT_STATE" { print $7 }')
read -r _ _ _ _ unchecked <<<"$(grep "^ROBOT_STATE " "$work/table")"
[ "$unchecked" -le "$lost" ] || failed "ROBOT_STATE: $unchecked not checked, $lost lost by the recorder"
for channel in TARGET JOINT_SETPOINT CONTROLLER_STATE JOINT_COMMAND; do
  read -r _ messages equal _ <<<"$(grep "^$channel " "$work/table")"
  [ "${equal:-0}" -gt 100 ] && [ $((100 * equal)) -ge $((99 * messages)) ] || failed "$channel: $equal of $messages computed again"
done
finish
