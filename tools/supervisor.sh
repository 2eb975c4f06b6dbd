# shellcheck shell=bash disable=SC2034,SC2154  # variables are shared with the script that sources this
# Sourced by launch.sh: restarts processes that exit.
#
# The caller has the folder $work, its name $me, and a function `command_of NAME [PART]` that sets the array `command`. What NAME writes goes to
# $work/NAME.out and $work/NAME.err.

backoff=(20 50 100 200 500)  # from an exit to the next start, in hundredths of a second; the last one repeats
settled=1000                 # after this uptime, the delays restart with the first
max_exits=5                  # so many exits of one process ...
exit_window=3000             # ... within this time end the run

declare -A pids=() born=() due=() parts=() starts=() delay_index=() exit_times=()
given_up=""       # a sentence: why the run must end
given_up_code=1   # its exit code
command=()

# Sets `now`: hundredths of a second on the monotonic clock.
read_clock() { local up; read -r up _ </proc/uptime; now=$((10#${up/./})); }

# start NAME: starts or restarts it, in a session of its own: Ctrl-C and a closed terminal reach only this script, which then ends them in
# order, the bridge first. The kernel sends it a signal when this script exits for any reason.
start() {
  local name=$1 signal=TERM
  parts[$name]=$((${parts[$name]:--1} + 1))
  command_of "$name" "${parts[$name]}"
  [[ $name != *_log ]] || signal=INT
  local run=(setpriv --pdeathsig "$signal" -- setsid "${command[@]}")
  if [ "$name" = view ]; then  # writes to this terminal
    "${run[@]}" 2> >(setsid grep --line-buffered -v '\[info\]' >&2) {lock}>&- &
  else
    "${run[@]}" >>"$work/$name.out" 2>>"$work/$name.err" {lock}>&- &
  fi
  pids[$name]=$!
  read_clock
  born[$name]=$now
  unset "due[$name]"
}

# stop NAME...: asks them to end, then ends them. STOP_SIGNAL: how to ask, default TERM.
stop() {
  local name signal=${STOP_SIGNAL:-TERM}
  for name in "$@"; do [ -z "${pids[$name]:-}" ] || kill -"$signal" "${pids[$name]}" 2>/dev/null; done
  for name in "$@"; do
    [ -n "${pids[$name]:-}" ] || continue
    for _ in $(seq 125); do kill -0 "${pids[$name]}" 2>/dev/null || break; sleep 0.02; done
    # Without `wait`: bash 5.2 may wait for one that is gone.
    disown "${pids[$name]}" 2>/dev/null
    kill -KILL "${pids[$name]}" 2>/dev/null
    while kill -0 "${pids[$name]}" 2>/dev/null; do sleep 0.02; done
    unset "pids[$name]"
  done
}

# ended NAME: whether a process that was started has exited; then `code` is its exit code.
ended() {
  [ -n "${pids[$1]:-}" ] && ! kill -0 "${pids[$1]}" 2>/dev/null || return 1
  wait "${pids[$1]}" 2>/dev/null
  code=$?
  unset "pids[$1]"
}

# Returns after a quarter of a second, a tenth of one while a process waits for its restart, or earlier when a process ends.
pause() { if [ ${#due[@]} -eq 0 ]; then sleep 0.25 {lock}>&- & else sleep 0.1 {lock}>&- & fi; wait -n 2>/dev/null; }

# cause_of NAME CODE: the end of a sentence about its exit.
cause_of() {
  if [ "$2" -gt 128 ] && kill -l $(($2 - 128)) >/dev/null 2>&1; then
    echo "was killed by SIG$(kill -l $(($2 - 128)))"
  else
    local last
    last=$(tail -n 1 "$work/$1.err" 2>/dev/null)
    echo "ended with code $2${last:+ ($last)}"
  fi
}

# keep NAME...: restarts those that have exited, each after its delay, with a message; sets `given_up` when the run must end.
keep() {
  local name
  read_clock
  for name in "$@"; do
    if [ -n "${due[$name]:-}" ]; then
      [ "$now" -lt "${due[$name]}" ] || { start "$name"; starts[$name]=$((${starts[$name]:-0} + 1)); }
    elif ended "$name"; then
      schedule_restart "$name" "$code"
    fi
    [ -z "$given_up" ] || return 1
  done
}

# schedule_restart NAME CODE: decides what to do after an exit.
schedule_restart() {
  local name=$1 code=$2 cause recent=() time delay
  cause=$(cause_of "$name" "$code")
  if [ "$code" -eq 2 ]; then  # wrong configuration: it would end in the same way again
    given_up="$name $cause" given_up_code=2
    return
  fi
  for time in ${exit_times[$name]:-} $now; do [ $((now - time)) -ge $exit_window ] || recent+=("$time"); done
  exit_times[$name]="${recent[*]}"
  if [ ${#recent[@]} -ge $max_exits ]; then
    given_up="$name $cause, the ${#recent[@]}th time within $((exit_window / 100)) s" given_up_code=1
    return
  fi
  [ $((now - born[$name])) -lt $settled ] || delay_index[$name]=0
  local index=${delay_index[$name]:-0}
  delay=${backoff[$index]}
  # The first restart of a recorder has no delay, so that it misses as little as possible.
  [[ $name != *_log || $index -ne 0 ]] || delay=0
  [ $((index + 1)) -ge ${#backoff[@]} ] || index=$((index + 1))
  delay_index[$name]=$index
  due[$name]=$((now + delay))
  echo "$me: $name $cause; it is started again in $((delay / 100)).$((delay % 100 / 10)) s" >&2
}

# restarts NAME...: prints how often these were restarted; nothing when none was.
restarts() {
  local name text=""
  for name in "$@"; do [ -z "${starts[$name]:-}" ] || text+="${text:+, }$name ${starts[$name]}"; done
  [ -z "$text" ] || echo "restarts: $text"
}
