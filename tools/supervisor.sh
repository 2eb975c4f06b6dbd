# shellcheck shell=bash disable=SC2034,SC2154  # variables are shared with the script that sources this
# Sourced by launch.sh: processes that are started again when they die.
#
# The caller has the folder $work and a function `command_of NAME [PART]` that sets the array `command`. What NAME writes goes to
# $work/NAME.out and $work/NAME.err.

backoff=(20 50 100 200 500)  # from a death to the next start, in hundredths of a second; the last one repeats
settled=1000                 # after this long a life, the delays begin anew
max_deaths=5                 # so many deaths of one process ...
death_window=3000            # ... within this time end the run

declare -A pids=() born=() due=() parts=() starts=() delay_index=() death_times=()
given_up=""       # a sentence: why the run must end
given_up_code=1   # its exit code
command=()

# Sets `now`: hundredths of a second on the monotonic clock.
read_clock() { local up; read -r up _ </proc/uptime; now=$((10#${up/./})); }

# start NAME: starts it, or starts it again. It is told to end when this script dies, however the script dies, and a terminal that
# closes does not kill it before it has stopped the robot.
start() {
  local name=$1 signal=TERM
  parts[$name]=$((${parts[$name]:--1} + 1))
  command_of "$name" "${parts[$name]}"
  [[ $name != *_log ]] || signal=INT
  local run=(env --ignore-signal=HUP setpriv --pdeathsig "$signal" -- "${command[@]}")
  if [ "$name" = view ]; then  # writes to this terminal
    "${run[@]}" 2> >(grep --line-buffered -v '\[info\]' >&2) {lock}>&- &
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
    kill -KILL "${pids[$name]}" 2>/dev/null
    wait "${pids[$name]}" 2>/dev/null
    unset "pids[$name]"
  done
}

# ended NAME: whether a process that was started is no more; then `code` is its exit code.
ended() {
  [ -n "${pids[$1]:-}" ] && ! kill -0 "${pids[$1]}" 2>/dev/null || return 1
  wait "${pids[$1]}" 2>/dev/null
  code=$?
  unset "pids[$1]"
}

# Returns after a tenth of a second, or earlier when a process ends.
pause() { sleep 0.1 {lock}>&- & wait -n 2>/dev/null; }

# cause_of NAME CODE: the end of a sentence about its death.
cause_of() {
  if [ "$2" -gt 128 ] && kill -l $(($2 - 128)) >/dev/null 2>&1; then
    echo "was killed by SIG$(kill -l $(($2 - 128)))"
  else
    local last
    last=$(tail -n 1 "$work/$1.err" 2>/dev/null)
    echo "ended with code $2${last:+ ($last)}"
  fi
}

# keep NAME...: starts again those of them that have died, each after its delay; says so; sets `given_up` when that is of no use.
keep() {
  local name
  read_clock
  for name in "$@"; do
    if [ -n "${due[$name]:-}" ]; then
      [ "$now" -lt "${due[$name]}" ] || { start "$name"; starts[$name]=$((${starts[$name]:-0} + 1)); }
    elif ended "$name"; then
      mourn "$name" "$code"
    fi
    [ -z "$given_up" ] || return 1
  done
}

# mourn NAME CODE: decides what to do about a death.
mourn() {
  local name=$1 code=$2 cause recent=() time delay
  cause=$(cause_of "$name" "$code")
  if [ "$code" -eq 2 ]; then  # wrong configuration: it would end in the same way again
    given_up="$name $cause" given_up_code=2
    return
  fi
  for time in ${death_times[$name]:-} $now; do [ $((now - time)) -ge $death_window ] || recent+=("$time"); done
  death_times[$name]="${recent[*]}"
  if [ ${#recent[@]} -ge $max_deaths ]; then
    given_up="$name $cause, the ${#recent[@]}th time within $((death_window / 100)) s" given_up_code=1
    return
  fi
  [ $((now - born[$name])) -lt $settled ] || delay_index[$name]=0
  local index=${delay_index[$name]:-0}
  delay=${backoff[$index]}
  # A recorder that was killed for the first time misses as little as possible.
  [[ $name != *_log || $index -ne 0 ]] || delay=0
  [ $((index + 1)) -ge ${#backoff[@]} ] || index=$((index + 1))
  delay_index[$name]=$index
  due[$name]=$((now + delay))
  echo "launch.sh: $name $cause; it is started again in $((delay / 100)).$((delay % 100 / 10)) s" >&2
}

# restarts NAME...: prints how often these were started again; nothing when none was.
restarts() {
  local name text=""
  for name in "$@"; do [ -z "${starts[$name]:-}" ] || text+="${text:+, }$name ${starts[$name]}"; done
  [ -z "$text" ] || echo "restarts: $text"
}
