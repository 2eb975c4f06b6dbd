# shellcheck shell=bash disable=SC2034,SC2154  # variables are shared with the test that sources this
# Sourced after launched.sh by tests of two computers, each a network namespace at the end of a virtual cable.
unshare --time true 2>/dev/null || { echo "skipped: a time namespace cannot be made here"; exit 77; }
declare -A hosts
parents=()
on_robot=()  # put before the programs of the robot's computer
trap 'kill "${hosts[@]}" "${parents[@]}" 2>/dev/null; wait "${parents[@]}" 2>/dev/null; rm -rf "$work"' EXIT
# host NAME ADDRESS SECONDS: a computer with a monotonic clock that is ahead. The other end of its cable is the interface to_NAME.
host() {
  unshare --net --time --monotonic "$3" --fork --kill-child sleep 1000 & parents+=($!)
  for _ in $(seq 50); do hosts[$1]=$(pgrep -P $!) && break; sleep 0.02; done
  ip link add dev "to_$1" type veth peer name eth0 netns "${hosts[$1]}"
  ip link set "to_$1" up
  on "$1" sh -c "ip link set lo up && ip address add $2/24 dev eth0 && ip link set eth0 up && ip route add 224.0.0.0/4 dev eth0"
}
on() { local name=$1; shift; nsenter --target "${hosts[$name]}" --net --time -- "$@"; }
# both OPTION...: a run on both computers; returns when images are sent. The processes are $eyes and $robot.
both() {
  nsenter --target "${hosts[robot]}" --net --time "${on_robot[@]}" env XDG_STATE_HOME="$work/robot" "$root/tools/launch.sh" --no-setup --role robot --json "$work/robot.json" >"$work/robot.out" 2>"$work/robot.err" & robot=$!
  rm -rf "$work/eyes"
  nsenter --target "${hosts[eyes]}" --net --time env XDG_STATE_HOME="$work/eyes" "$root/tools/launch.sh" --no-setup --role eyes --json "$work/eyes.json" "$@" >"$work/eyes.out" 2>"$work/eyes.err" & eyes=$!
  until compgen -G "$work/eyes/multireach/runs/*/source.err" >/dev/null || ! kill -0 "$eyes" 2>/dev/null; do sleep 0.05; done
}
both_ended() {
  name=eyes; wait "$eyes"; eyes_code=$?
  kill "$robot"; wait "$robot"; robot_code=$?
}
# interrupted: pulls the cable of the cameras' computer for 2 s, during a run of `both --seconds 10`, and waits for its end.
interrupted() {
  local url='udpm://239.255.76.67:7667?ttl=1'
  sleep 3.5; ip link set to_eyes down
  sleep 1.5; on robot "$bin/multireach-robot" --lcm-url "$url" status >"$work/unplugged"
  grep -q '^armed' "$work/unplugged" || failed "unplugged, the bridge is '$(cat "$work/unplugged")'"
  sleep 0.5; ip link set to_eyes up
  for _ in $(seq 15); do
    sleep 0.2; on robot "$bin/multireach-robot" --lcm-url "$url" status >"$work/plugged"
    grep -q '^running' "$work/plugged" && break
  done
  grep -q '^running' "$work/plugged" || failed "plugged in again, the bridge is '$(cat "$work/plugged")'"
  both_ended
  name=robot
  awk -v speed="$(report max_command_speed_share)" 'BEGIN { exit !(speed > 0 && speed <= 1.06) }' || failed "the commands move at $(report max_command_speed_share) of the speed limit"
  [ "$(report max_limit_violation_rad)" = 0.0 ] || failed "beyond a limit: $(report max_limit_violation_rad)"
}
