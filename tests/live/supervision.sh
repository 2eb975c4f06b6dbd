#!/usr/bin/env bash
# Each process that launch.sh started is killed: it is restarted and the motion resumes as docs/safety.md says; one that exits
# repeatedly, or that refuses its configuration, ends the run.
bin=$1
timed=yes
. "$(dirname "$0")/namespace.sh"
. "$root/tests/live/launched.sh"
slow_enough() {
  local share
  share=$(report max_command_speed_share)
  awk -v share="$share" 'BEGIN { exit !(share > 0) }' || failed "$name: the commands move at '$share' of the speed limit"
  awk -v share="$share" 'BEGIN { exit !(share <= 1.06) }' || wrong "$name: the commands move at $share of the speed limit"
}

# Vision and the controller, while the arm stays at a target: the whole session is reached all the same.
launch eyes
sleep 2.3; killed multireach-vision
sleep 3.2; killed multireach-controller
sleep 1.2; await_state 15 running
ended 0
says '^launch.sh: vision was killed by SIGKILL; it is started again in 0.2 s$'
says '^restarts: controller 1, vision 1$'
[ "$(restarts_of vision) $(restarts_of controller) $(restarts_of bridge)" = "1 1 0" ] || failed "the report counts $(restarts_of vision) and $(restarts_of controller) restarts"
slow_enough

# The bridge, while the arm stays near the set-points: resumes by itself. The simulated robot: a fault, until it is reset.
# A processor that is kept for the bridge stays so.
readarray -t processors < <(for range in $(taskset -cp $$ | sed 's/.*: //; s/,/ /g'); do seq "${range%-*}" "${range#*-}"; done)
reserve=()
[ ${#processors[@]} -eq 1 ] || reserve=(--reserve "${processors[-1]}")
launch robot --seconds 15 "${reserve[@]}"
sleep 2.3; killed multireach-bridge
sleep 1; await_state 15 running
for node in vision controller bridge robot-sim; do
  [ ${#reserve[@]} -gt 0 ] || break
  list=$(taskset -cp "$(pgrep -P "$launched" -f "multireach-$node" | head -n 1)" | sed 's/.*: //')
  [ "$list" != "${reserve[1]}" ] || [ $node = bridge ] || wrong "$node runs on the bridge's processor"
  [ "$list" = "${reserve[1]}" ] || [ $node != bridge ] || failed "the bridge runs on processors $list"
done
killed multireach-robot-sim
await_state 4 'fault: the robot was restarted'
"$bin/multireach-robot" reset >"$work/out" 2>&1 || failed "reset: $(cat "$work/out")"
await_state 5 running
sleep 2
"$bin/multireach-robot" status | grep -q running || failed "does not stay running: $("$bin/multireach-robot" status)"
wait $launched
says '^restarts: bridge 1, robot_sim 1$'
slow_enough

# In the middle of a motion, after the ball jumped at 10 s: the new process continues from the robot's position.
launch moving-controller
sleep 10.5; killed multireach-controller
sleep 1.5; await_state 15 running
ended 0
slow_enough
launch moving-bridge --seconds 14
sleep 10.5; killed multireach-bridge
sleep 1; await_state 15 running
wait $launched
slow_enough

# A tree in which vision ends at once.
mkdir -p "$work/tree/build/release/bin"
ln -s "$root/robots" "$root/logs" "$root/tools" "$work/tree/"
ln -s "$bin"/* "$work/tree/build/release/bin/"
dies() { printf '#!/bin/sh\necho "the lens fell off" >&2\nexit %s\n' "$1" >"$work/vision"; chmod +x "$work/vision"; ln -sf "$work/vision" "$work/tree/build/release/bin/multireach-vision"; }
rm "$work/tree/tools"; mkdir "$work/tree/tools"; cp "$root"/tools/*.sh "$work/tree/tools/"
expect() {
  name="ends with $1"
  dies "$1"
  timeout 30 "$work/tree/tools/launch.sh" --no-setup 2>"$work/$name.err"
  local code=$?
  [ $code -eq "$2" ] || failed "$name: exit code $code, expected $2: $(cat "$work/$name.err")"
  says "$3"
}
expect 1 1 '^launch.sh: vision ended with code 1 \(the lens fell off\), the 5th time within 30 s$'
expect 2 2 '^launch.sh: vision did not start$'
[ "$(grep -c 'started again' "$work/ends with 2.err")" = 0 ] || wrong "a wrong configuration is tried again"
finish
