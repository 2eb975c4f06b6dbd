#!/usr/bin/env bash
# Garbled messages on every channel: every node counts and ignores them, and continues its work.
bin=$1
. "$(dirname "$0")/namespace.sh"
robot="$root/robots/hoap2/robot.yaml"
"$bin/multireach-vision" --config "$root/robots/hoap2/vision.yaml" --seconds 12 2>"$work/vision.err" & vision=$!
"$bin/multireach-controller" --config "$robot" --seconds 12 2>"$work/controller.err" & controller=$!
"$bin/multireach-bridge" --config "$robot" --seconds 12 2>"$work/bridge.err" & bridge=$!
"$bin/multireach-robot-sim" --config "$robot" --seconds 12 2>"$work/sim.err" & sim=$!
"$bin/multireach-view" --robot "$robot" --wait-for vision,controller,bridge,robot_sim --seconds 30 2>/dev/null || failed "the nodes did not start"
LD_PRELOAD="$bin/libmultireach-datagram-guard.so" lcm-logger --lcm-url='udpm://239.255.76.67:7667?ttl=0' --force --quiet "$work/control.lcm" & logger=$!
"$bin/multireach-test-garbage" 2>&1 || failed "the garbage could not be sent"
"$bin/multireach-camera" render --config "$root/logs/reach.yaml" --seconds 4 2>/dev/null
for node in vision controller bridge sim; do
  wait "${!node}" || failed "$node ended with code $?: $(cat "$work/$node.err")"
done
kill -INT $logger; wait $logger 2>/dev/null
"$bin/multireach-log" report "$work/control.lcm" --robot "$robot" --json "$work/report.json" >/dev/null 2>&1
for node in vision controller bridge robot_sim; do
  refused=$(tr -d ' \n' <"$work/report.json" | grep -o "\"$node\":{[^}]*" | grep -o '"refused":[0-9]*' | cut -d: -f2)
  [ "${refused:-0}" -ge 100 ] || failed "$node refused only '${refused:-0}' messages"
done
# The 200 garbled ones are recorded too.
grep -q '"targets": 3[0-9][0-9]' "$work/report.json" || failed "vision did not go on: $(grep targets "$work/report.json")"
grep -qE '"commands": [0-9]{4}' "$work/report.json" || failed "the bridge did not go on: $(grep commands "$work/report.json")"
finish
