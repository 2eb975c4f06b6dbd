# shellcheck shell=bash disable=SC2034,SC2154  # variables are shared with the script that sources this
# Sourced by scripts that record with lcm-logger.
# await_written LOG...: waits until lcm-logger has written what it received (at most 20 s). It drops the rest when it ends, and
# a slow disk delays it. To be called when no process sends any more.
await_written() {
  local before=none now
  for _ in $(seq 20); do
    now=$(stat -c %s "$@" 2>/dev/null | tr '\n' ' ')
    [ "$now" = "$before" ] && return
    before=$now
    sleep 1
  done
}
