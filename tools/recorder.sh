# Sourced by scripts that record with lcm-logger.
# await_written LOG...: waits until lcm-logger has written what it received (at most 20 s). It drops the rest when it is ended, and
# a slow disk holds it up. To be called when nobody sends any more.
await_written() {
  local before=none now
  for _ in $(seq 20); do
    now=$(stat -c %s "$@" 2>/dev/null | tr '\n' ' ')
    [ "$now" = "$before" ] && return
    before=$now
    sleep 1
  done
}

# folder_for_recording MEGABYTES: prints a folder in memory if it has that much room, else the one for temporary files.
folder_for_recording() {
  local free
  free=$(df --output=avail --block-size=1M /dev/shm 2>/dev/null | tail -n1)
  if [ -w /dev/shm ] && [ "${free:-0}" -ge "$1" ]; then echo /dev/shm; else echo "${TMPDIR:-/tmp}"; fi
}
