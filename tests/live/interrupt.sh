#!/usr/bin/env bash
# Ctrl-C ends launch.sh and every process that it started, soon; so does killing the script itself.
bin=$1
. "$(dirname "$0")/namespace.sh"
left_over() { pgrep -f "$work/" | wc -l; }
# Copies under a name of this test's own, so that only its processes are looked for.
mkdir -p "$work/tree/build/release"
ln -s "$bin" "$work/tree/build/release/bin"
ln -s "$root/robots" "$root/logs" "$work/tree/"
mkdir "$work/tree/tools"
cp "$root"/tools/*.sh "$work/tree/tools/"

for signal in INT TERM HUP KILL; do
  # A shell lets what it puts in the background ignore Ctrl-C; a terminal does not.
  env --default-signal=INT setsid "$work/tree/tools/launch.sh" --no-setup 2>"$work/launch.err" >/dev/null & script=$!
  sleep 6
  running=$(left_over)
  [ "$running" -ge 5 ] || failed "only $running processes run before the signal: $(cat "$work/launch.err")"
  kill -$signal $script
  for _ in $(seq 50); do [ "$(left_over)" -eq 0 ] && break; sleep 0.1; done
  [ "$(left_over)" -eq 0 ] || failed "after $signal still running: $(pgrep -af "$work/")"
  wait $script 2>/dev/null
done

# In a terminal, Ctrl-C goes to all processes of the script's group, also to the commands that it waits for. At any time.
for seconds in 0.05 0.1 0.2 0.3 0.6 1 1.5 2 2.5 3 4; do
  env --default-signal=INT setsid "$work/tree/tools/launch.sh" --no-setup 2>"$work/launch.err" >/dev/null & script=$!
  sleep "$seconds"
  kill -INT -- "-$script"
  for _ in $(seq 80); do kill -0 $script 2>/dev/null || break; sleep 0.1; done
  if kill -0 $script 2>/dev/null; then failed "runs on 8 s after Ctrl-C, $seconds s after the start: $(cat "$work/launch.err")"; kill -KILL -- "-$script"; fi
  wait $script
  code=$?
  [ $code -eq 130 ] || failed "exit code $code after Ctrl-C, $seconds s after the start: $(cat "$work/launch.err")"
  for _ in $(seq 20); do [ "$(left_over)" -eq 0 ] && break; sleep 0.1; done
  [ "$(left_over)" -eq 0 ] || failed "after Ctrl-C, $seconds s after the start, still running: $(pgrep -af "$work/")"
  grep -q 'started again' "$work/launch.err" && failed "after Ctrl-C, $seconds s after the start: $(cat "$work/launch.err")"
done
finish
