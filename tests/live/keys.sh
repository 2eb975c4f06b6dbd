#!/usr/bin/env bash
# Processes with a key refuse unsigned, altered and replayed messages, and those of another key, and count each by name; stock LCM tools record
# and play them; the whole loop runs, and its log is verified, as without a key.
bin=$1
timed=yes
. "$(dirname "$0")/namespace.sh"
command -v python3 >/dev/null || { echo "skipped: python3 is not here"; exit 77; }
unset MULTIREACH_KEY MULTIREACH_KEY_POLICY
robot="$root/robots/hoap2/robot.yaml"
control='udpm://239.255.76.67:7667?ttl=0' images='udpm://239.255.76.68:7668?ttl=0'
key=$work/key

"$bin/multireach-key" new "$key" 2>/dev/null || wrong "no key was made"
[ "$(stat -c %a "$key")" = 600 ] || wrong "the key's mode is $(stat -c %a "$key")"
"$bin/multireach-key" new "$key" 2>"$work/err" && wrong "a key was replaced"
grep -qF "exists already" "$work/err" || wrong "it is not said why a key is not replaced: $(cat "$work/err")"
"$bin/multireach-key" share "$key" | "$bin/multireach-key" new "$work/second" --shared 2>/dev/null || wrong "the key cannot be shared"
cmp "$key" "$work/second" || wrong "the shared key is another one"
"$bin/multireach-key" share "$key" | tr 1 2 | "$bin/multireach-key" new "$work/third" --shared 2>/dev/null && wrong "a damaged key is taken"
"$bin/multireach-key" new "$work/other" 2>/dev/null
cp "$key" "$work/public"; chmod 644 "$work/public"
"$bin/multireach-controller" --config "$robot" --key "$work/public" 2>"$work/err"
[ $? -eq 2 ] || wrong "a key that others may read is used"
grep -qF "chmod 600 $work/public" "$work/err" || wrong "no fix for a key that others may read: $(cat "$work/err")"

# The processes have copies of the key.
declare -A pids
run() { "$bin/multireach-$1" --lockstep --config "$2" --key "$work/second" 2>>"$work/$1.err" & pids[$1]=$!; }
run vision "$root/robots/hoap2/vision.yaml"
for node in controller bridge robot-sim; do run $node "$robot"; done
"$bin/multireach-view" --robot "$robot" --key "$key" --wait-for vision,controller,bridge,robot_sim --seconds 30 2>/dev/null || failed "the nodes did not start"
lcm-logger --lcm-url="$control&recv_buf_size=4194304" --force --quiet "$work/all.lcm" & logger=$!
sleep 0.3
status() { "$bin/multireach-robot" --key "$key" status 2>&1; }
is() { local state; state=$(status); [[ $state =~ ^$1 ]] || failed "$2: the bridge is '$state', expected $1"; }
is armed "at first"

# Nothing unsigned, and nothing of another key, moves the arm or is answered.
timeout 2 "$bin/multireach-publish" target 0.1 -0.12 0.1 --robot "$robot" 2>/dev/null
timeout 2 "$bin/multireach-publish" target 0.1 -0.12 0.1 --robot "$robot" --key "$work/other" 2>/dev/null
is armed "after targets unsigned and of another key"
"$bin/multireach-robot" stop >"$work/out" 2>&1 && wrong "an unsigned request is answered: $(cat "$work/out")"
grep -q "with the same --key" "$work/out" || wrong "no hint at the key: $(cat "$work/out")"
"$bin/multireach-robot" --key "$work/other" stop >/dev/null 2>&1 && wrong "a request of another key is answered"
"$bin/multireach-replay" run "$root/logs/reach.lcm" --until 4 -o "$work/old.lcm" >/dev/null || failed "run"
lcm-logplayer --lcm-url="$control" --regexp='TARGET|JOINT_SETPOINT|JOINT_COMMAND|ROBOT_STATE|BRIDGE_REQUEST' "$work/old.lcm" >/dev/null
lcm-logplayer --lcm-url="$images" --regexp=STEREO_IMAGES "$work/old.lcm" >/dev/null
is armed "after an unsigned log"

# What is signed moves it.
lcm-logger --lcm-url="$control&recv_buf_size=4194304" --force --quiet "$work/signed.lcm" & second=$!
sleep 0.3
"$bin/multireach-publish" target 0.1 -0.12 0.1 --robot "$robot" --key "$key" 2>/dev/null & publisher=$!
sleep 1
is running "with signed targets"
kill $publisher; wait $publisher 2>/dev/null
"$bin/multireach-robot" --key "$key" stop >/dev/null || failed "a signed request is not answered"
kill -INT $second; wait $second 2>/dev/null
sleep 1

# The recording, played again, is refused, and so is a copy in which a bit of each message is flipped.
"$bin/multireach-log" info "$work/signed.lcm" >"$work/info" || failed "info"
awk 'NR > 2 && $NF != 0' "$work/info" | grep . && failed "malformed: $(cat "$work/info")"
python3 - "$work/signed.lcm" "$work/altered.lcm" <<'END'
import struct, sys
log, at = bytearray(open(sys.argv[1], "rb").read()), 0
while at + 28 <= len(log):
    channel, data = struct.unpack(">ii", log[at + 20:at + 28])
    log[at + 28 + channel + data // 3] ^= 16
    at += 28 + channel + data
open(sys.argv[2], "wb").write(log)
END
for log in signed altered; do
  lcm-logplayer --lcm-url="$control" --regexp='TARGET|JOINT_SETPOINT|JOINT_COMMAND|ROBOT_STATE|BRIDGE_REQUEST' "$work/$log.lcm" >/dev/null
done
sleep 1.5
is 'fault|armed|idle' "after logs that were played again"
kill -INT $logger; wait $logger 2>/dev/null
"$bin/multireach-replay" play "$root/logs/reach.lcm" --lockstep --until 1 --key "$key" >"$work/out" 2>&1 || failed "in lockstep: $(cat "$work/out")"
for node in vision controller bridge robot-sim; do kill "${pids[$node]}"; wait "${pids[$node]}" || failed "$node: $(cat "$work/$node.err")"; done
"$bin/multireach-log" report "$work/all.lcm" --robot "$robot" --json "$work/report.json" 2>"$work/table"
refused() { python3 -c "import json, sys; print(json.load(open(sys.argv[1]))['nodes'][sys.argv[2]]['refused_' + sys.argv[3]])" "$work/report.json" "$@"; }
for node in controller bridge robot_sim; do
  for cause in unsigned altered replayed; do
    [ "$(refused $node $cause)" -gt 10 ] || failed "$node counts $(refused $node $cause) as $cause"
  done
done
[ "$(refused vision unsigned)" -gt 10 ] || failed "vision counts $(refused vision unsigned) as unsigned"
[ "$(refused controller other_key)" -gt 10 ] || failed "controller counts $(refused controller other_key) of another key"
[ "$(refused bridge other_key)" -gt 0 ] || failed "bridge counts $(refused bridge other_key) of another key"
grep "refused messages" "$work/table"
grep -q "^controller refused messages: .* unsigned, .* altered, .* replayed, .* of another key" "$work/table" || failed "the table does not name the refusals: $(cat "$work/table")"
grep -q "a message on TARGET is refused and counted as unsigned" "$work/controller.err" || failed "the controller does not say what it refuses"
grep -q "whoever reaches" "$work/controller.err" && wrong "with a key, it is said that anybody may command"
"$bin/multireach-controller" --config "$robot" --seconds 0.5 2>"$work/err"
[ "$(grep -c "whoever reaches" "$work/err")" -eq 1 ] || wrong "without a key, it is not said once that anybody may command: $(cat "$work/err")"

# A policy lets plain tools in.
echo 'optional: [TARGET]' >"$work/policy.yaml"
"$bin/multireach-controller" --config "$robot" --key "$key" --key-policy "$work/policy.yaml" 2>"$work/policy.err" & pids[controller]=$!
"$bin/multireach-robot-sim" --config "$robot" --key "$key" 2>/dev/null & pids[robot-sim]=$!
lcm-logger --lcm-url="$control" --force --quiet "$work/policy.lcm" & logger=$!
sleep 0.7
timeout 1.5 "$bin/multireach-publish" target 0.1 -0.12 0.1 --robot "$robot" 2>/dev/null
kill "${pids[controller]}" "${pids[robot-sim]}"; wait "${pids[controller]}" "${pids[robot-sim]}"
kill -INT $logger; wait $logger 2>/dev/null
"$bin/multireach-log" info "$work/policy.lcm" | grep -q JOINT_SETPOINT || failed "an unsigned target is refused where the policy lets it in: $(cat "$work/policy.err")"

# The whole loop, and its log.
if [ "$bin" -ef "$root/build/release/bin" ]; then
  "$root/tools/launch.sh" --no-setup --key "$key" --seconds 12 --record "$work/run.lcm" --json "$work/report.json" >/dev/null 2>"$work/err" || failed "launch.sh: exit code $?: $(cat "$work/err")"
  for node in vision controller bridge robot_sim; do
    for cause in unsigned altered replayed other_key; do
      [ "$(refused $node $cause)" = 0 ] || failed "launch.sh: $node counts $(refused $node $cause) as $cause"
    done
  done
  "$bin/multireach-replay" verify "$work/run.lcm" >"$work/out" || failed "verify: $(cat "$work/out")"
  cat "$work/out"
  "$root/tools/launch.sh" --no-setup --key "$work/none" 2>"$work/err"
  [ $? -eq 2 ] || wrong "launch.sh runs without the key that it was given"
  grep -qF "key new $work/none" "$work/err" || wrong "launch.sh does not say how to make a key: $(cat "$work/err")"
fi
finish
