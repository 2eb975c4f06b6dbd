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

for signal in INT TERM KILL; do
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
finish
