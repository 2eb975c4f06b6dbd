#!/usr/bin/env bash
# The whole loop as separate processes: vision, controller, bridge and the simulated robot, fed by a recorded camera session
# or a camera. Records all traffic, restarts processes that exit, shows a status line while it runs and prints a table at the end.
set -uo pipefail
export LC_NUMERIC=C
scripts=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
# shellcheck source=tools/location.sh
. "$scripts/location.sh"
# shellcheck source=tools/recorder.sh
. "$scripts/recorder.sh"
# shellcheck source=tools/groups.sh
. "$scripts/groups.sh"
# shellcheck source=tools/supervisor.sh
. "$scripts/supervisor.sh"

usage() {
  echo "Runs the whole loop as separate processes, fed by a recorded session or a camera; prints a report at the end."
  echo "Usage: $me [options]"
  cat <<'EOF'
  --session FILE    play this recorded camera session with lcm-logplayer (default: the scene.yaml of the robot, rendered; else
                    logs/reach.lcm)
  --camera SOURCE   instead of a session, run multireach-camera with these arguments, as --camera "render --config logs/reach.yaml"
  --robot DIR       folder of the robot, with robot.yaml and vision.yaml, or one that comes with multireach (default: robots/hoap2)
  --driver NAME     instead of the simulated robot, the driver of a real one (docs/robots.md): iiwa, panda, ur, dynamixel, feetech,
                    template
  --emulator        the driver (default: that of the robot.yaml) with an emulator of the robot instead of the robot
  --no-robot        start no robot: another process publishes ROBOT_STATE (docs/your-robot.md)
  --vision FILE     vision.yaml (default: NAME.vision.yaml next to the session NAME.lcm if it exists, else the robot's)
  --speed X         seconds of message time per second (default: 1)
  --seconds N       end after N seconds
  --record FILE     keep the log of all traffic
  --json FILE       write the report
  --role ROLE       which part runs on this computer: eyes (camera, vision, controller), robot (bridge, robot) or all (default)
  --group N         UDP groups and ports of its own, 0 to 255, for several instances on one computer or network
                    (default: LCM_DEFAULT_URL, else LCM's default group)
  --key FILE        sign all messages with this key, and refuse others (docs/keys.md; default: MULTIREACH_KEY of the environment)
  --key-policy FILE which channels are signed (default: MULTIREACH_KEY_POLICY, else all of multireach)
  --isolated        in a network namespace of its own, so that no message leaves the machine
  --view            also serve a page that shows and controls the run (docs/view.md), print its address, and open it on a desktop
                    (default on a desktop: where there is a terminal, a display, xdg-open, and no --role)
  --text            no page: only the status line
  --drake           with --view: also send what Drake's viewer meldis shows
  --course DIR      with --view: the page leads through the set-up of two cameras, whose files are in DIR (docs/calibrate.md); also with
                    --camera "device ..."; nothing is recorded
  --practice        the same with rendered cameras and the simulated robot, in a network namespace and a folder of their own
  --host ADDRESS    where the page is served (default: 127.0.0.1); 0.0.0.0 lets other computers in
  --port N          the page's port (default: one that is free)
  --reserve N       keep processor N for the bridge: it runs there, and nothing else of this run does (docs/safety.md#measured)
  --no-setup        do not install or build anything (an installed multireach never does)
  --help            print this help and end
Exit code: 0 if every reachable position was reached and no limit exceeded, 1 if not or if a process failed, 2 for wrong usage.
EOF
}
fail() { echo "$me: $1" >&2; exit "${2:-2}"; }

session="" driver="" robot_kind=simulated
camera="" robot="$root/robots/hoap2" vision="" speed=1 seconds="" record="" json="" role=all group=""
key=${MULTIREACH_KEY:-} key_policy=${MULTIREACH_KEY_POLICY:-}
course="" practice=no
isolated=no setup=yes view=auto drake=no host=127.0.0.1 port=0 reserve=""

read_options() {
  local option
  while [ $# -gt 0 ]; do
    case "$1" in
      --session|--camera|--robot|--driver|--vision|--speed|--seconds|--record|--json|--role|--group|--key|--key-policy|--course|--host|--port|--reserve)
        [ $# -ge 2 ] || fail "$1 needs a value; see --help"
        option=${1#--}
        printf -v "${option//-/_}" '%s' "$2"; shift 2 ;;
      --emulator) robot_kind=emulated; shift ;;
      --no-robot) robot_kind=none; shift ;;
      --isolated) isolated=yes; shift ;;
      --view) view=yes; shift ;;
      --text) view=no; shift ;;
      --drake) drake=yes; shift ;;
      --practice) practice=yes; shift ;;
      --no-setup) setup=no; shift ;;
      --help|-h) usage; exit 0 ;;
      *) fail "unknown option '$1'; see --help" ;;
    esac
  done
}

check_options() {
  local number='^[0-9]*\.?[0-9]+$' file
  [[ $speed =~ $number ]] || fail "--speed: '$speed' is not a positive number"
  [[ -z $seconds || $seconds =~ $number ]] || fail "--seconds: '$seconds' is not a positive number"
  [[ "$role" =~ ^(all|eyes|robot)$ ]] || fail "--role: '$role' is not one of all, eyes, robot"
  [[ -z $group || $group =~ ^(0|[1-9][0-9]{0,2})$ && $group -le 255 ]] || fail "--group: '$group' is not a number from 0 to 255"
  check_reserve
  [ $isolated = no ] || [ "$role" = all ] || fail "--role $role needs the network that --isolated takes away"
  [ "$(basename "$robot")" != robot.yaml ] || robot=$(dirname "$robot")
  [ -r "$robot/robot.yaml" ] || [ ! -r "$root/$robot/robot.yaml" ] || robot=$root/$robot
  [ -r "$robot/robot.yaml" ] || fail "--robot: '$robot' has no robot.yaml"
  check_robot_kind
  choose_view
  check_course
  if [ -z "$camera$session" ] && [ -r "$robot/scene.yaml" ]; then
    printf -v camera 'render --drop-late --config %q' "$robot/scene.yaml"
  fi
  [ -z "$camera" ] || [ "$installed" = no ] || [ -x "$bin/multireach-camera" ] ||
    fail "the program multireach-camera is not installed; it is in the Debian package multireach-camera" 1
  [ -n "$camera$session" ] || [ "$role" = robot ] || [ "$robot" -ef "$root/robots/hoap2" ] ||
    fail "--robot: '$robot' has no scene.yaml; expected --camera, e.g. --camera 'device --left 0 --right 2', or --session FILE"
  : "${session:=$root/logs/reach.lcm}"
  [ -n "$camera" ] || [ -r "$session" ] || fail "--session: '$session' cannot be read"
  if [ -z "$vision" ]; then
    vision="$robot/vision.yaml"
    [ -z "$camera" ] && [ -r "${session%.lcm}.vision.yaml" ] && vision="${session%.lcm}.vision.yaml"
  fi
  [ -r "$vision" ] || [ -n "$course" ] || fail "--vision: '$vision' cannot be read"
  for file in "$record" "$json"; do
    [ -z "$file" ] || [ "$file" = - ] || [ -w "$(dirname "$file")" ] || fail "'$file' cannot be written: its folder does not exist or is not writable"
  done
  [ -z "$record" ] || ! [ "$record" -ef "$session" ] || fail "--record: '$record' is the session itself"
  choose_groups
  check_key
}

# --reserve N: this runs on the other processors.
check_reserve() {
  [ -n "$reserve" ] || return 0
  local list range all shared
  list=$(taskset -cp $$ | sed 's/.*: //')
  all=$(for range in ${list//,/ }; do seq "${range%-*}" "${range#*-}"; done)
  grep -qxF -- "$reserve" <<<"$all" || fail "--reserve: '$reserve' is not a processor that this may use: $list"
  shared=$(grep -vxF -- "$reserve" <<<"$all" | paste -sd,)
  [ -n "$shared" ] || fail "--reserve: processor $reserve is the only one"
  taskset -cp "$shared" $$ >/dev/null  # and with it all that this starts
}

on_desktop() { [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ] && [ -t 1 ] && [ -t 2 ] && command -v xdg-open >/dev/null; }
page_is_built() { [ -x "$bin/multireach-page" ] && { [ "$installed" = yes ] || [ -e "$root/build/web/index.html" ]; }; }

# Without --view and --text, there is a page on a desktop.
choose_view() {
  view_by_default=no
  [ $drake = no ] || [ $view = yes ] || [ $practice = yes ] || fail "--drake needs --view"
  [ $view = auto ] || return 0
  view=no
  if [ "$role" = all ] && [ -z "$course" ] && on_desktop && { [ $setup = yes ] || page_is_built; }; then view=yes view_by_default=yes; fi
}

# A practice never reaches a real robot: no driver, and no message leaves the network namespace.
check_course() {
  if [ $practice = yes ]; then
    if [ -n "$driver$session$camera$vision" ] || [ $robot_kind != simulated ] || [ "$robot" != "$root/robots/hoap2" ] || [ "$role" != all ]; then
      fail "--practice has a robot and cameras of its own: without --driver, --emulator, --no-robot, --robot, --session, --camera, --vision, --role"
    fi
    view=yes isolated=yes
    : "${course:=${XDG_DATA_HOME:-${HOME:-/tmp}/.local/share}/multireach/practice}"
    printf -v camera 'practice --robot %q --vision %q' "$robot" "$robot/vision.yaml"
  fi
  [ -n "$course" ] || return 0
  [ $view = yes ] || fail "--course needs --view"
  [ -n "$camera" ] || fail '--course needs --camera, as --camera "device --left 0 --right 2"'
  [ -z "$vision$record$json" ] || fail "--course is without --vision, --record and --json"
  mkdir -p "$course" || fail "--course: '$course' cannot be made"
  course=$(cd "$course" && pwd)
  vision="$course/vision.yaml"
}

# Hands the key to all programs that this script starts.
check_key() {
  [ -z "$key" ] || [ -r "$key" ] || fail "--key: '$key' cannot be read; to make a key:  $run_program key new $key"
  [ -z "$key_policy" ] || [ -n "$key" ] || fail "--key-policy: is only allowed with --key"
  [ -z "$key_policy" ] || [ -r "$key_policy" ] || fail "--key-policy: '$key_policy' cannot be read"
  export MULTIREACH_KEY=$key MULTIREACH_KEY_POLICY=$key_policy
}

# Chooses what replaces the simulated robot.
check_robot_kind() {
  [ -z "$driver" ] || [ $robot_kind != none ] || fail "--no-robot starts no driver; give only one of --driver and --no-robot"
  [ -z "$driver" ] || [ $robot_kind != simulated ] || robot_kind=real
  case $robot_kind in
    simulated) robot_nodes=(robot_sim) ;;
    emulated) robot_nodes=(robot_emulator robot_driver) ;;
    real) robot_nodes=(robot_driver) ;;
    none) robot_nodes=() ;;
  esac
  [ $robot_kind = simulated ] || [[ $speed =~ ^0*1(\.0*)?$ ]] || fail "--speed: the time of a robot cannot be changed; expected 1"
}

# Sets `control` and `images`. Between two computers only images stay on their own.
choose_groups() {
  local ttl=0
  [ "$role" = all ] || ttl=1
  groups_of "$group" $ttl || fail "$groups_error"
  [ "$role" = all ] || [[ $control =~ [?\&]ttl=[1-9] ]] || fail "LCM_DEFAULT_URL: '$control' does not leave this computer; --role $role needs ttl=1"
  [ "$role" = all ] || [[ $images != *ttl=* ]] || images=${images/ttl=*/ttl=0}
  [ -z "$group" ] || echo "$me: for other programs:  export LCM_DEFAULT_URL='$control'" >&2
}

# Opens the page in the desktop's browser. Other users of this computer see the arguments of programs, so the address with its token is
# in a file that only this user reads.
open_browser() {
  local file=${XDG_STATE_HOME:-${HOME:-/tmp}/.local/state}/multireach/page.html
  mkdir -p "$(dirname "$file")" && rm -f "$file" &&
    (umask 077 && printf '<meta http-equiv="refresh" content="0; url=%s"><title>multireach</title>\n' "$MULTIREACH_PAGE_ADDRESS" >"$file") || return 0
  (xdg-open "$file" >/dev/null 2>&1 &)
}

# Continues with the page's socket, which is open before the network is left, and stays open when the page's process is started again.
open_socket() {
  echo "$me: the page is at the address below" >&2
  exec "$bin/multireach-page" --host "$host" --port "$port" -- "$0" --no-setup "$@"
}

# Continues in a network namespace, with the arguments of this script.
isolate() {
  local user=() text=()
  [ $view = yes ] || text=(--text)
  [ "$(id -u)" -eq 0 ] || user=(--map-root-user)
  export MULTIREACH_ISOLATED=1
  exec unshare "${user[@]}" --net -- sh -c 'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$0" "$@"' \
    "$0" --no-setup "${text[@]}" "$@"
}

# Recordings are kept here until they are merged, so that they survive this script.
runs=${XDG_STATE_HOME:-${HOME:-/tmp}/.local/state}/multireach/runs

finish_commands() {
  printf '  %s\n' "$run_program log merge $1/*.lcm -o run.lcm" "$run_program log report run.lcm --robot $(cat "$1/robot")" "rm -r $1"
}

# Prints where unfinished runs are.
tell_unfinished() {
  local folder
  for folder in "$runs"/*; do
    if [ ! -e "$folder/lock" ] || ! flock --nonblock "$folder/lock" true 2>/dev/null; then continue; fi
    if [ -z "$(find "$folder" -name '*.lcm' -size +0)" ]; then rm -r "$folder"; continue; fi
    echo "$me: an earlier run was killed; its recording is in $folder. To finish it:" >&2
    finish_commands "$folder" >&2
  done
}

make_folder() {
  tell_unfinished
  work=$runs/$(date +%Y-%m-%d_%H-%M-%S).$$
  mkdir -p "$work" 2>/dev/null || work=$(mktemp -d) || fail "no folder for the recording can be made" 1
  exec {lock}>"$work/lock"
  flock "$lock"
  (cd "$robot" && pwd) >"$work/robot"
  trap clean_up EXIT
  trap 'interrupted=yes' INT TERM HUP
  trap '' TSTP  # Ctrl-Z would leave the robot moving without this script
}

keep_folder=no  # while it holds a recording that is not merged
clean_up() {
  stop bridge  # first: the robot follows it to rest
  stop "${!pids[@]}"
  if [ "$keep_folder" = no ]; then rm -rf "$work"; return; fi
  echo "$me: the recording is in $work. To finish it:" >&2
  finish_commands "$work" >&2
}

# command_of NAME PART: sets `command` to what a process runs. Each part of a recording is a file.
command_of() {
  local part=${2/#0/}
  case "$1" in
    vision)
      command=("$bin/multireach-vision" --config "$vision" "${live[@]}")
      # The set-up course writes the file after a while.
      [ -z "$course" ] || command=(bash -c 'until [ -s "$0" ]; do sleep 0.2; done; exec "$@"' "$vision" "${command[@]}") ;;
    controller|bridge) command=("$bin/multireach-$1" --config "$robot/robot.yaml" "${live[@]}") ;;
    robot_sim) command=("$bin/multireach-robot-sim" --config "$robot/robot.yaml" "${live[@]}") ;;
    robot_emulator) command=("$bin/multireach-robot-emulator" --config "$robot/robot.yaml" ${driver:+--driver "$driver"} --device "$work/serial" "${live[@]}") ;;
    robot_driver)
      command=("$bin/multireach-robot-driver" --config "$robot/robot.yaml" ${driver:+--driver "$driver"} "${live[@]}")
      [ $robot_kind = real ] || command+=(--simulated --device "$work/serial")
      [ -z "${MULTIREACH_WIRE_REPORT:-}" ] || command+=(--wire-report "$MULTIREACH_WIRE_REPORT") ;;
    control_log) command=("${urgent[@]}" env LD_PRELOAD="$guard" lcm-logger --lcm-url="$(with_buffer "$control")" --force --quiet "$work/control${part:+.$part}.lcm") ;;
    image_log) command=("${urgent[@]}" env LD_PRELOAD="$guard" lcm-logger --lcm-url="$(with_buffer "$images")" --force --quiet "$work/images${part:+.$part}.lcm") ;;
    wait) command=("$bin/multireach-view" --robot "$robot/robot.yaml" "${live[@]}" --wait-for "$awaited" --seconds "$patience") ;;
    page)
      command=("$bin/multireach-page" --robot "$robot/robot.yaml" --lcm-url "$control" --image-url "$images")
      [ ! -r "$vision" ] || command+=(--vision "$vision")
      [ -z "$course" ] || command+=(--course "$course")
      [ $drake = no ] || command+=(--drake)
      [ $practice = no ] || command+=(--practice) ;;
    view) command=("$bin/multireach-view" --robot "$robot/robot.yaml" "${live[@]}") ;;
    source)
      if [ -n "$camera" ]; then
        command=("$bin/multireach-camera" "${live[@]}" "${camera_arguments[@]}")
      elif [ -n "$key" ]; then
        command=("$bin/multireach-publish" --lcm-url "$control" --image-url "$images" session "$session" --speed "$speed")
      else
        command=(lcm-logplayer --lcm-url="$images" --speed="$speed" --regexp='STEREO_IMAGES|TARGET_TRUTH' "$session")
      fi ;;
  esac
  [ -z "$reserve" ] || [ "$1" != bridge ] || command=(taskset -c "$reserve" "${command[@]}")
}
with_buffer() { [[ $1 == *\?* ]] && echo "$1&recv_buf_size=4194304" || echo "$1?recv_buf_size=4194304"; }

choose_processes() {
  nodes=(vision controller bridge "${robot_nodes[@]}") loggers=(control_log image_log) others=()
  [ "$role" != eyes ] || { nodes=(vision controller); others=(bridge "${robot_nodes[@]}"); }
  [ "$role" != robot ] || { nodes=(bridge "${robot_nodes[@]}"); loggers=(control_log); }
  [ -z "$course" ] || loggers=()
  live=(--lcm-url "$control" --image-url "$images" --speed "$speed")
  camera_arguments=()
  [ -z "$camera" ] || eval "camera_arguments=($camera)"
  # lcm-logger queues 30 messages of a channel, 30 ms of commands: it gets a higher priority than the nodes where the system allows this.
  urgent=()
  if chrt --fifo 10 true 2>/dev/null; then urgent=(chrt --fifo 10); fi
  supervised=("${loggers[@]}" "${nodes[@]}")
  [ $view = no ] || supervised+=(page)
}

start_nodes() {
  local name
  for name in "${supervised[@]}"; do start "$name"; done
  if [ -z "$course" ]; then awaited_nodes=("${nodes[@]}"); else awaited_nodes=(controller bridge); fi
  await 10 "the nodes did not start" "${awaited_nodes[@]}"
  [ ${#others[@]} -eq 0 ] || echo "$me: waiting for the robot's computer" >&2
  [ ${#others[@]} -eq 0 ] || await 60 "no NODE_STATUS arrives from the robot's computer" "${others[@]}"
}

# An emulated robot needs some seconds, e.g. to release its brakes, before its ROBOT_STATE arrives at the bridge.
await_emulator() {
  local end
  [ $robot_kind = emulated ] && [ "$role" = all ] || return 0
  read_clock
  end=$((now + 2000))
  while [ $interrupted = no ] && [[ $("$bin/multireach-robot" --lcm-url "$control" status 2>/dev/null) != armed* ]]; do
    keep "${supervised[@]}" || give_up_at_start
    [ "$now" -lt $end ] || { cat "$work/robot_driver.err" >&2; fail "the emulated robot is not ready" 1; }
    pause
  done
}

# await SECONDS SENTENCE NODE...: until all of them have sent NODE_STATUS.
await() {
  local sentence=$2
  patience=$1 awaited=$(IFS=,; echo "${*:3}")
  start wait
  until [ $interrupted = yes ] || ended wait; do
    keep "${supervised[@]}" || { stop wait; give_up_at_start; }
    pause
  done
  [ $interrupted = no ] || exit 130
  [ "$code" -eq 0 ] && return
  cat "$work/wait.err" >&2
  [ "$code" -eq 2 ] && exit 2
  fail "$sentence" 1
}

give_up_at_start() {
  cat "$work/${given_up%% *}.err" >&2
  [ "$given_up_code" -ne 2 ] || fail "${given_up%% *} did not start" 2
  fail "$given_up" 1
}

# The set-up course: vision starts again whenever its file has changed.
follow_vision_file() {
  [ -n "$course" ] || return 0
  local written
  written=$(stat -c %y "$vision" 2>/dev/null)
  [ "$written" != "$vision_written" ] || return 0
  vision_written=$written
  stop vision
  unset "due[vision]"
  start vision
}
vision_written=""

# Runs the source of images; the run ends with it.
feed() {
  local end="" feeds=(source)
  [ -n "$course" ] || keep_folder=yes
  supervised+=(view)
  start view
  if [ "$role" = robot ]; then feeds=(); else start source; fi
  if [ -n "$seconds" ]; then read_clock; end=$((now + $(printf '%.0f' "${seconds}e2"))); fi
  while [ $interrupted = no ] && keep "${supervised[@]}"; do
    if [ -n "$end" ] && [ "$now" -ge "$end" ]; then break; fi
    follow_vision_file
    if [ ${#feeds[@]} -gt 0 ] && ended source; then
      [ "$code" -ne 0 ] || break
      source_failed "$code" || break
    fi
    [ -z "${due[source]:-}" ] || keep source
    pause
  done
  [ $interrupted = yes ] || sleep 0.5  # for messages in transit
}

# A camera is restarted; a session cannot be continued where it ended.
source_failed() {
  [ $interrupted = no ] || return 1
  if [ -n "$camera" ]; then schedule_restart source "$1"; else given_up="the source of images $(cause_of source "$1")"; fi
  [ "$1" -ne 2 ] || { given_up="the source of images $(cause_of source 2)" given_up_code=2; cat "$work/source.err" >&2; }
  [ -z "$given_up" ]
}

stop_all() {
  stop page view source
  [ -t 2 ] && echo >&2
  stop bridge  # first: the robot follows it to rest
  stop "${nodes[@]}"
  # The other computer may go on sending.
  if [ "$role" = all ] && [ -z "$course" ]; then await_written "$work"/*.lcm; else sleep 1; fi
  STOP_SIGNAL=INT stop "${loggers[@]}"
  grep -hE '\[(warning|error)\]' "$work"/*.err >&2
}

# Merges the recording and prints the report; returns the run's exit code.
report() {
  local full="$work/run" logs=() log code
  for log in "$work"/*.lcm; do [ -s "$log" ] && logs+=("$log"); done
  [ ${#logs[@]} -gt 0 ] || { keep_folder=no; fail "nothing was recorded" 1; }
  "$bin/multireach-log" merge "${logs[@]}" --output "$full" || return 1
  if [ -n "$record" ]; then cp "$full" "$record" || fail "--record: '$record' cannot be written" 1; fi
  "$bin/multireach-log" report "$full" --robot "$robot/robot.yaml" ${json:+--json "$json"}
  code=$?
  keep_folder=no
  restarts "${loggers[@]}" >&2  # the report has the restarts of the nodes
  [ -z "$given_up" ] || fail "$given_up" "$given_up_code"
  # The robot's computer does not know when the run is over: a signal ends its run.
  if [ $interrupted = yes ] && [ "$role" != robot ]; then return 130; fi
  return $code
}

# Without a trap, bash ignores Ctrl-C when the command that it waits for ends as usual. With one, no command may have two substitutions
# $(): in bash 5.2, a trap that runs between them is a syntax error.
trap 'exit 130' INT
read_options "$@"
check_options
if [ $setup = yes ] && [ "$installed" = no ]; then
  needed=(loop ${camera:+camera})
  if [ $view_by_default = yes ]; then
    "$root/tools/setup.sh" "${needed[@]}" page || view=no  # a run does not need npm
  fi
  [ $view = no ] || needed+=(page)
  [ $view_by_default$view = yesyes ] || "$root/tools/setup.sh" "${needed[@]}" || exit 1
  [ $view_by_default$view != yesno ] || echo "$me: without the page, which cannot be built here (see above; --text does not try)" >&2
fi
if [ -z "$camera" ] && [ "$role" != robot ]; then "$bin/multireach-log" merge "$session" --output /dev/null || exit 2; fi
[ $view = no ] || [ -n "${MULTIREACH_PAGE_SOCKET:-}" ] || open_socket "$@"
if [ $view = yes ] && [ -z "${MULTIREACH_ISOLATED:-}" ] && [ -n "${MULTIREACH_PAGE_ADDRESS:-}" ] && on_desktop; then open_browser; fi
[ $isolated = no ] || [ -n "${MULTIREACH_ISOLATED:-}" ] || isolate "$@"
[ -n "$key${MULTIREACH_ISOLATED:-}" ] || echo "$me: no --key: whoever reaches the LCM group may command the robot (docs/keys.md)" >&2
interrupted=no
make_folder
choose_processes
start_nodes
await_emulator
feed
stop_all
if [ -n "$course" ]; then
  [ -z "$given_up" ] || fail "$given_up" "$given_up_code"
  echo "$me: the files of the set-up are in $course" >&2
  if [ $interrupted = yes ]; then exit 130; else exit 0; fi
fi
report
exit $?
