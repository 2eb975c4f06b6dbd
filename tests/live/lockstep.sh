#!/usr/bin/env bash
# Live processes in lockstep send the bytes of `run`, faster than real time, under load, and when messages are lost.
bin=$1
. "$(dirname "$0")/namespace.sh"
robot="$root/robots/hoap2/robot.yaml"
control='udpm://239.255.76.67:7667?ttl=0' images='udpm://239.255.76.68:7668?ttl=0'
declare -A pids
# Appends: to empty a file waits for the disk.
run() { "$bin/multireach-$1" --lockstep --config "$2" 2>>"$work/$1.err" & pids[$1]=$!; }
run vision "$root/robots/hoap2/vision.yaml"
for node in controller bridge robot-sim; do run $node "$robot"; done
"$bin/multireach-view" --robot "$robot" --wait-for vision,controller,bridge,robot_sim --seconds 30 2>/dev/null || failed "the nodes did not start"
lcm-logger --lcm-url="$control&recv_buf_size=4194304" --force --quiet "$work/control.lcm" & logger=$!
sleep 0.3
play() { "$bin/multireach-replay" play "$root/logs/reach.lcm" --lockstep "$@" >"$work/out" 2>&1; }
play --robot-model sim || failed "with the simulated robot: $(cat "$work/out")"
cat "$work/out"
sleep 1; kill -INT $logger; wait $logger 2>/dev/null
"$bin/multireach-replay" run "$root/logs/reach.lcm" --robot-model sim -o "$work/run.lcm" >/dev/null || failed "run"
# The simulated robot also sends before and after the replay, under another run.
"$bin/multireach-log" filter "$work/control.lcm" --channel ROBOT_STATE SIM_STEP --without -o "$work/live.lcm" 2>/dev/null || failed "filter"
# The recorder may have lost some of what came so fast, but what it has is what run gives.
"$bin/multireach-replay" bisect "$work/run.lcm" "$work/live.lcm" --common >"$work/bisect" 2>&1 || failed "other bytes than run: $(cat "$work/bisect")"
cat "$work/bisect"
sh -c 'while :; do :; done' & load=$!
play --until 8 || failed "with the ideal robot, under load: $(cat "$work/out")"
cat "$work/out"
kill $load
kill -STOP "${pids[bridge]}"; (sleep 2; kill -CONT "${pids[bridge]}") &
play --until 1 || failed "a node that stops for two seconds: $(cat "$work/out")"
kill -KILL "${pids[controller]}"
play --until 1 && failed "without a controller"
grep -q "controller did not answer" "$work/out" || failed "it is not said which node is missing: $(cat "$work/out")"
sed 's/alpha_per_step: 0.08/alpha_per_step: 0.081/' "$robot" >"$work/robot.yaml"; cp "$root/robots/hoap2/hoap2.urdf" "$work"
run controller "$work/robot.yaml"
sleep 0.5
play --until 3 && failed "with another configuration"
grep -qE "JOINT_SETPOINT [0-9]+: joint_position\[[0-9]\] is .* from controller" "$work/out" || failed "the difference is not named: $(cat "$work/out")"
for node in vision controller bridge robot-sim; do kill "${pids[$node]}"; wait "${pids[$node]}" || failed "$node: $(cat "$work/$node.err")"; done
finish
