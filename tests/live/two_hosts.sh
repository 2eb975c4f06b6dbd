#!/usr/bin/env bash
# Two computers on a switch, as network namespaces: cameras and controller on one, bridge and robot on the other. All positions are
# reached; when the cable of the first is pulled for two seconds, the arm stops on a ramp and continues by itself.
bin=$1
. "$(dirname "$0")/namespace.sh"
. "$root/tests/live/launched.sh"
if ! ip link add dev switch type bridge mcast_snooping 0 2>/dev/null; then echo "skipped: a network bridge cannot be made here"; exit 77; fi
ip link set switch up
unshare --time true 2>/dev/null || { echo "skipped: a time namespace cannot be made here"; exit 77; }
declare -A hosts
parents=()
trap 'kill "${hosts[@]}" 2>/dev/null; wait "${parents[@]}" 2>/dev/null; rm -rf "$work"' EXIT
# host NAME ADDRESS SECONDS: a network namespace, with a cable to the switch and a monotonic clock that is ahead.
host() {
  unshare --net --time --monotonic "$3" --fork --kill-child sleep 1000 & parents+=($!)
  for _ in $(seq 50); do hosts[$1]=$(pgrep -P $!) && break; sleep 0.02; done
  ip link add dev "to_$1" type veth peer name eth0 netns "${hosts[$1]}"
  ip link set "to_$1" master switch up
  on "$1" sh -c "ip link set lo up && ip address add $2/24 dev eth0 && ip link set eth0 up && ip route add 224.0.0.0/4 dev eth0"
}
on() { local name=$1; shift; nsenter --target "${hosts[$name]}" --net --time -- "$@"; }
# both OPTION...: a run on both hosts; returns when images are sent. The processes are $eyes and $robot.
both() {
  nsenter --target "${hosts[robot]}" --net --time env XDG_STATE_HOME="$work/robot" "$root/tools/launch.sh" --no-setup --role robot --json "$work/robot.json" 2>"$work/robot.err" & robot=$!
  rm -rf "$work/eyes"
  nsenter --target "${hosts[eyes]}" --net --time env XDG_STATE_HOME="$work/eyes" "$root/tools/launch.sh" --no-setup --role eyes --json "$work/eyes.json" "$@" 2>"$work/eyes.err" & eyes=$!
  until compgen -G "$work/eyes/multireach/runs/*/source.err" >/dev/null || ! kill -0 $eyes 2>/dev/null; do sleep 0.05; done
}
both_ended() {
  name=eyes; wait $eyes; eyes_code=$?
  kill $robot; wait $robot; robot_code=$?
}
host eyes 10.0.0.1 0
host robot 10.0.0.2 86400

both
both_ended
[ $eyes_code -eq 0 ] || failed "eyes: exit code $eyes_code: $(cat "$work/eyes.err")"
[ $robot_code -eq 0 ] || failed "robot: exit code $robot_code: $(cat "$work/robot.err")"
for name in eyes robot; do [ "$(reached)" -ge 6 ] || failed "$name: $(reached) positions reached"; done
name=robot; [ "$(report images)" = 0 ] || failed "$(report images) pairs of images were sent to the robot's computer"

both --seconds 10
sleep 3.5; ip link set to_eyes down
sleep 1.5; on robot "$bin/multireach-robot" --lcm-url 'udpm://239.255.76.67:7667?ttl=1' status >"$work/unplugged"
grep -q '^armed' "$work/unplugged" || failed "unplugged, the bridge is '$(cat "$work/unplugged")'"
sleep 0.5; ip link set to_eyes up
sleep 3; on robot "$bin/multireach-robot" --lcm-url 'udpm://239.255.76.67:7667?ttl=1' status >"$work/plugged"
grep -q '^running' "$work/plugged" || failed "plugged in again, the bridge is '$(cat "$work/plugged")'"
both_ended
name=robot
awk -v speed="$(report max_command_speed_share)" 'BEGIN { exit !(speed > 0 && speed <= 1.06) }' || failed "the commands move at $(report max_command_speed_share) of the speed limit"
[ "$(report max_limit_violation_rad)" = 0.0 ] || failed "beyond a limit: $(report max_limit_violation_rad)"
[ -z "${MULTIREACH_KEEP:-}" ] || cat "$work"/{eyes,robot}.err
finish
