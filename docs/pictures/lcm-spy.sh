#!/usr/bin/env bash
# Makes docs/pictures/lcm-spy.png: lcm-spy beside the running loop, with all channels and the fields of four, on a virtual screen (Debian's
# packages xvfb, xdotool, imagemagick). --no-setup: everything is built.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
if [ -z "${MULTIREACH_ISOLATED:-}" ]; then
  [ "${1:-}" = --no-setup ] || "$root/tools/setup.sh" loop spy
  # A network namespace of its own, as for launch.sh --isolated, with lcm-spy inside.
  export MULTIREACH_ISOLATED=1
  exec unshare --map-root-user --net -- sh -c 'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$0"' "$0"
fi
work=$(mktemp -d)
export DISPLAY=:97 _JAVA_AWT_WM_NONREPARENTING=1 HOME=$work
started=()
trap 'kill "${started[@]}" 2>/dev/null || true; wait; rm -rf "$work"' EXIT
Xvfb $DISPLAY -screen 0 1280x1000x24 -nolisten tcp >/dev/null 2>&1 & started+=($!)
until xdotool getdisplaygeometry >/dev/null 2>&1; do kill -0 $!; sleep 0.1; done
sed "s|^end_s:.*|end_s: 300|; s|^vision: .*|vision: $root/robots/hoap2/vision.yaml|" "$root/logs/reach.yaml" >"$work/scene.yaml"
"$root/tools/launch.sh" --no-setup --text --camera "render --config $work/scene.yaml" >"$work/out" 2>&1 & started+=($!)
"$root/tools/spy.sh" >"$work/spy" 2>&1 & started+=($!)

# place WINDOW X Y WIDTH HEIGHT
place() { xdotool windowsize --sync "$1" "$4" "$5" windowmove "$1" "$2" "$3"; }
until [ "$(xdotool search --onlyvisible --name '^LCM Spy' | wc -l)" -ge 2 ]; do sleep 0.2; done
# The one that was started first shows the control group.
mapfile -t spies < <(for spy in $(xdotool search --onlyvisible --name '^LCM Spy'); do echo "$(xdotool getwindowpid "$spy") $spy"; done | sort -n | cut -d' ' -f2)
place "${spies[0]}" 0 0 640 215
place "${spies[1]}" 640 0 640 215
sleep 10  # until all channels are there

# shows CHANNEL ROW SPY X Y: a double click on the row opens a window with the channel's fields.
shows() {
  local fields
  until fields=$(xdotool search --onlyvisible --name "^$1\$" | tail -1) && [ -n "$fields" ]; do
    xdotool mousemove --window "$3" 60 $((28 + 16 * $2)) click --repeat 2 --delay 60 1
    sleep 2
  done
  place "$fields" "$4" "$5" 640 390
}
shows STEREO_IMAGES 0 "${spies[1]}" 640 610
shows TARGET 8 "${spies[0]}" 640 218
shows JOINT_COMMAND 2 "${spies[0]}" 0 610
shows CONTROLLER_STATE 1 "${spies[0]}" 0 218
sleep 5  # for the curves
import -window root "${PICTURE:-$root/docs/pictures/lcm-spy.png}"
