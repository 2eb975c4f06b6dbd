#!/usr/bin/env bash
# Records logs/load.lcm again, and logs/damaged.lcm from it: the whole loop as live processes on a machine that is busy with
# other work, while the recorder stops twice and controller and bridge are killed and restarted.
#   logs/record_load.sh [FOLDER]        where to write; default: this folder
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
folder=$(cd "${1:-$root/logs}" && pwd)
bin="$root/build/release/bin"
. "$root/tools/recorder.sh"
if [ -z "${MULTIREACH_ISOLATED:-}" ]; then
  user=()
  [ "$(id -u)" -eq 0 ] || user=(--map-root-user)
  export MULTIREACH_ISOLATED=1
  exec unshare "${user[@]}" --net -- sh -c 'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$0" "$@"' "$0" "$folder"
fi
work=$(mktemp -d)
declare -A pids
trap 'kill "${pids[@]}" 2>/dev/null || true; rm -rf "$work"' EXIT
robot="$root/robots/hoap2/robot.yaml"
run() { "$bin/multireach-$1" --config "$2" 2>/dev/null & pids[$1]=$!; }
restart() { kill -KILL "${pids[$1]}"; wait "${pids[$1]}" 2>/dev/null || true; run "$1" "$robot"; }
pause() { kill -STOP "${pids[$1]}"; sleep "$2"; kill -CONT "${pids[$1]}"; }
lcm-logger --lcm-url='udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304' --force --quiet "$work/control.lcm" & pids[control_log]=$!
lcm-logger --lcm-url='udpm://239.255.76.68:7668?ttl=0&recv_buf_size=4194304' --force --quiet "$work/images.lcm" & pids[image_log]=$!
run vision "$root/robots/hoap2/vision.yaml"
for node in controller bridge robot-sim; do run $node "$robot"; done
"$bin/multireach-view" --robot "$robot" --wait-for vision,controller,bridge,robot_sim --seconds 8 2>/dev/null
for k in 1 2 3 4; do sh -c 'while :; do :; done' & pids[load$k]=$!; done
"$bin/multireach-camera" render --config "$root/logs/load.yaml" 2>/dev/null & camera=$!
sleep 1.5; pause control_log 0.15
sleep 0.8; restart controller
sleep 1; pause vision 0.2
sleep 1; restart bridge
sleep 0.7; pause control_log 0.15
wait $camera
for k in 1 2 3 4; do kill "${pids[load$k]}"; wait "${pids[load$k]}" 2>/dev/null || true; unset "pids[load$k]"; done
for name in vision controller bridge robot-sim; do kill "${pids[$name]}"; wait "${pids[$name]}" || true; done
await_written "$work"/{control,images}.lcm
kill -INT "${pids[control_log]}" "${pids[image_log]}"
wait "${pids[control_log]}" "${pids[image_log]}" || true
"$bin/multireach-log" merge "$work/control.lcm" "$work/images.lcm" --output "$work/load.lcm"
# A stop of the recorder may lose the inputs after which a node's messages cannot be checked for long.
unchecked=$("$bin/multireach-replay" verify "$work/load.lcm" 2>/dev/null | awk '
  $1 ~ /^(TARGET|JOINT_SETPOINT|CONTROLLER_STATE|JOINT_COMMAND)$/ && $3 != $2 { printf "%s %d of %d messages of %s", n++ ? "," : "", $2 - $3, $2, $1 }')
if [ -n "$unchecked" ]; then
  echo "record_load.sh: in this recording cannot be checked:$unchecked; nothing was written, run it again" >&2
  exit 1
fi
mv "$work/load.lcm" "$folder/load.lcm"

# Two seconds of it, damaged: a byte of a header, a run of zeros over several events, a byte of an image, and no end.
"$bin/multireach-log" cut "$folder/load.lcm" --from 2 --until 4 -o "$work/cut.lcm"
size=$(stat -c %s "$work/cut.lcm")
at() { printf "$2" | dd of="$work/cut.lcm" bs=1 seek="$1" conv=notrunc status=none; }
LC_ALL=C grep -obUaP '\xed\xa1\xda\x01' "$work/cut.lcm" | cut -d: -f1 >"$work/events"
nth() { sed -n "$1p" "$work/events"; }
image=$(awk 'NR > 1 && $1 - last > 8000 && last > size / 2 { print last; exit } { last = $1 }' size="$size" "$work/events")
at $(($(nth 100) + 24)) '\x7f'
dd if=/dev/zero of="$work/cut.lcm" bs=1 seek=$(($(nth 500) + 10)) count=2000 conv=notrunc status=none
at $((image + 4000)) '\x00\x00\x00\x00'
truncate -s $((size - 77)) "$work/cut.lcm"
mv "$work/cut.lcm" "$folder/damaged.lcm"
(cd "$folder" && sha256sum load.lcm damaged.lcm)
