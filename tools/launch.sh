#!/usr/bin/env bash
# The whole loop as separate processes: vision, controller, bridge and the simulated robot, fed by a recorded camera session
# or a camera; all traffic recorded; a live line while it runs and a table at the end.
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
bin="$root/build/release/bin"
. "$root/tools/recorder.sh"

usage() {
  cat <<'EOF'
Usage: tools/launch.sh [options]
  --session FILE    play this recorded camera session (default: logs/reach.lcm) with lcm-logplayer
  --camera SOURCE   instead of a session, run multireach-camera with these arguments, as --camera "render --config logs/reach.yaml"
  --robot DIR       folder of the robot, with robot.yaml and vision.yaml (default: robots/hoap2)
  --vision FILE     vision.yaml (default: NAME.vision.yaml next to the session NAME.lcm if it exists, else the robot's)
  --speed X         seconds of message time per second (default: 1)
  --seconds N       end after N seconds
  --record FILE     keep the log of all traffic
  --json FILE       write the report
  --isolated        in a network namespace of its own, so that nothing leaves the machine
  --no-setup        do not install or build anything
  --help
Exit code: 0 if every reachable position was reached and no limit exceeded, 1 if not or if a process failed, 2 for wrong usage.
EOF
}
fail() { echo "launch.sh: $1" >&2; exit "${2:-2}"; }

session="$root/logs/reach.lcm" camera="" robot="$root/robots/hoap2" vision="" speed=1 seconds="" record="" json="" isolated=no setup=yes
arguments=("$@")
while [ $# -gt 0 ]; do
  case "$1" in
    --session|--camera|--robot|--vision|--speed|--seconds|--record|--json)
      [ $# -ge 2 ] || fail "$1 needs a value; see --help"
      declare "${1#--}=$2"; shift 2 ;;
    --isolated) isolated=yes; shift ;;
    --no-setup) setup=no; shift ;;
    --help|-h) usage; exit 0 ;;
    *) fail "unknown option '$1'; see --help" ;;
  esac
done
number='^[0-9]*\.?[0-9]+$'
[[ $speed =~ $number ]] || fail "--speed: '$speed' is not a positive number"
[[ -z $seconds || $seconds =~ $number ]] || fail "--seconds: '$seconds' is not a positive number"
[ -n "$camera" ] || [ -r "$session" ] || fail "--session: '$session' cannot be read"
[ -r "$robot/robot.yaml" ] || fail "--robot: '$robot' has no robot.yaml"
if [ -z "$vision" ]; then
  vision="$robot/vision.yaml"
  [ -z "$camera" ] && [ -r "${session%.lcm}.vision.yaml" ] && vision="${session%.lcm}.vision.yaml"
fi
[ -r "$vision" ] || fail "--vision: '$vision' cannot be read"

for file in "$record" "$json"; do
  [ -z "$file" ] || [ "$file" = - ] || [ -w "$(dirname "$file")" ] || fail "'$file' cannot be written: its folder does not exist or is not writable"
done
[ -z "$record" ] || ! [ "$record" -ef "$session" ] || fail "--record: '$record' is the session itself"

if [ $setup = yes ]; then "$root/tools/setup.sh" loop ${camera:+camera} || exit 1; fi
if [ -z "$camera" ]; then "$bin/multireach-log" merge "$session" --output /dev/null || exit 2; fi

if [ $isolated = yes ] && [ -z "${MULTIREACH_ISOLATED:-}" ]; then
  user=()
  [ "$(id -u)" -eq 0 ] || user=(--map-root-user)
  export MULTIREACH_ISOLATED=1
  exec unshare "${user[@]}" --net -- sh -c 'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$0" "$@"' \
    "$0" --no-setup "${arguments[@]}"
fi

control=${LCM_DEFAULT_URL:-udpm://239.255.76.67:7667?ttl=0}
images=udpm://239.255.76.68:7668?ttl=0
if [ "$control" != 'udpm://239.255.76.67:7667?ttl=0' ]; then
  # As the programs have it: the same group, one port above.
  [[ $control =~ ^udpm://([0-9.]+):([0-9]+)(\?.*)?$ ]] || fail "LCM_DEFAULT_URL: '$control' is not udpm://ADDRESS:PORT?ttl=N"
  images="udpm://${BASH_REMATCH[1]}:$((BASH_REMATCH[2] + 1))${BASH_REMATCH[3]}"
fi
buffer='&recv_buf_size=4194304'
[[ $control == *\?* ]] || buffer="?${buffer#&}"
work=$(mktemp -d)
declare -A pids=()

# Each process gets a signal when this script dies, however it dies.
start() {
  local name=$1; shift
  setpriv --pdeathsig TERM -- "$@" >"$work/$name.out" 2>"$work/$name.err" &
  pids[$name]=$!
}
stop() {
  local name signal=${STOP_SIGNAL:-TERM}
  for name in "$@"; do [ -n "${pids[$name]:-}" ] && kill -"$signal" "${pids[$name]}" 2>/dev/null; done
  for name in "$@"; do
    [ -n "${pids[$name]:-}" ] || continue
    for _ in $(seq 100); do kill -0 "${pids[$name]}" 2>/dev/null || break; sleep 0.02; done
    kill -KILL "${pids[$name]}" 2>/dev/null
    wait "${pids[$name]}" 2>/dev/null
    unset "pids[$name]"
  done
}
clean_up() { stop "${!pids[@]}"; rm -rf "$work"; }
trap clean_up EXIT
interrupted=no
trap 'interrupted=yes' INT TERM

nodes=(vision controller bridge robot_sim)
live=(--lcm-url "$control" --image-url "$images" --speed "$speed")
check() {
  local name
  [ $interrupted = no ] || return
  for name in "${nodes[@]}" control_log image_log; do
    kill -0 "${pids[$name]}" 2>/dev/null && continue
    wait "${pids[$name]}"; local code=$?
    cat "$work/$name.err" >&2
    unset "pids[$name]"
    [ $code -eq 2 ] && fail "$name did not start" 2
    fail "$name ended with code $code" 1
  done
}

# lcm-logger holds 30 messages of a channel, 30 ms of commands: where the system allows it, it goes before the others.
urgent=()
chrt --fifo 10 true 2>/dev/null && urgent=(chrt --fifo 10)
start control_log "${urgent[@]}" lcm-logger --lcm-url="$control$buffer" --force --quiet "$work/control.lcm"
start image_log "${urgent[@]}" lcm-logger --lcm-url="$images$buffer" --force --quiet "$work/images.lcm"
start vision "$bin/multireach-vision" --config "$vision" "${live[@]}"
start controller "$bin/multireach-controller" --config "$robot/robot.yaml" "${live[@]}"
start bridge "$bin/multireach-bridge" --config "$robot/robot.yaml" "${live[@]}"
start robot_sim "$bin/multireach-robot-sim" --config "$robot/robot.yaml" "${live[@]}"
all=$(IFS=,; echo "${nodes[*]}")
start wait "$bin/multireach-view" --robot "$robot/robot.yaml" "${live[@]}" --wait-for "$all" --seconds 10
wait "${pids[wait]}"
waited=$?
[ $interrupted = yes ] && exit 130
[ $waited -eq 2 ] && { cat "$work/wait.err" >&2; exit 2; }
check
[ $waited -eq 0 ] || { cat "$work/wait.err" >&2; fail "the nodes did not start" 1; }

# The view writes to this terminal.
setpriv --pdeathsig TERM -- "$bin/multireach-view" --robot "$robot/robot.yaml" "${live[@]}" 2> >(grep --line-buffered -v '\[info\]' >&2) &
pids[view]=$!
if [ -n "$camera" ]; then
  eval "camera_arguments=($camera)"
  start source "$bin/multireach-camera" "${live[@]}" "${camera_arguments[@]}"
else
  start source lcm-logplayer --lcm-url="$images" --speed="$speed" --regexp='STEREO_IMAGES|TARGET_TRUTH' "$session"
fi
begin=$SECONDS
while kill -0 "${pids[source]}" 2>/dev/null && [ $interrupted = no ]; do
  check
  if [ -n "$seconds" ] && [ "$(printf '%.0f' "$seconds")" -le $((SECONDS - begin)) ]; then break; fi
  sleep 0.1
done
if ! kill -0 "${pids[source]}" 2>/dev/null; then
  wait "${pids[source]}"; code=$?
  unset "pids[source]"
  if [ $code -ne 0 ] && [ $interrupted = no ]; then cat "$work/source.err" >&2; fail "the source of images ended with code $code" $((code == 2 ? 2 : 1)); fi
fi
[ $interrupted = yes ] || sleep 0.5  # what is still on its way
stop view source
[ -t 2 ] && echo >&2
stop "${nodes[@]}"
await_written "$work"/{control,images}.lcm
STOP_SIGNAL=INT stop control_log image_log
grep -hE '\[(warning|error)\]' "$work"/*.err >&2

full="$work/run.lcm"
logs=()
for log in "$work/control.lcm" "$work/images.lcm"; do [ -s "$log" ] && logs+=("$log"); done
[ ${#logs[@]} -gt 0 ] || fail "nothing was recorded" 1
"$bin/multireach-log" merge "${logs[@]}" --output "$full" || exit 1
if [ -n "$record" ]; then cp "$full" "$record" || fail "--record: '$record' cannot be written"; fi
"$bin/multireach-log" report "$full" --robot "$robot/robot.yaml" ${json:+--json "$json"}
code=$?
[ $interrupted = yes ] && exit 130
exit $code
