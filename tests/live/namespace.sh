# Sourced by the scripts of this folder: runs the calling script again in a network namespace of its own, so that no message
# leaves the test, or skips it (exit code 77) where that is not allowed. Where arms have to reach targets in time, a script sets
# `timed=yes` before: if it fails while the machine stops its processes (multireach-test-lateness), it is run up to three times, then
# skipped, for the bridge begins again from rest after each gap of more than 3 ms. What no lateness excuses (a limit exceeded, a
# wrong file) is reported by `wrong`, and fails at once.
if [ -z "${MULTIREACH_ISOLATED:-}" ]; then
  user=()
  [ "$(id -u)" -eq 0 ] || user=(--map-root-user)
  if ! unshare "${user[@]}" --net true 2>/dev/null; then
    echo "skipped: a network namespace cannot be made here"
    exit 77
  fi
  export MULTIREACH_ISOLATED=1
  isolated=(unshare "${user[@]}" --net -- sh -c 'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$0" "$@"' "$0" "$@")
  [ "${timed:-}" = yes ] || exec "${isolated[@]}"
  for pause in 0 10 10; do
    sleep $pause
    "${isolated[@]}"
    code=$?
    [ $code -eq 75 ] || exit $code
  done
  echo "skipped: this machine stops its processes too often"
  exit 77
fi
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
work=$(mktemp -d)
export XDG_STATE_HOME="$work/state"  # unfinished recordings of launch.sh
trap 'rm -rf "$work"' EXIT
failures=0 wrongs=0
failed() { echo "FAILED: $1"; failures=$((failures + 1)); }
wrong() { failed "$1"; wrongs=$((wrongs + 1)); }
if [ "${timed:-}" = yes ] && [ -x "$bin/multireach-test-lateness" ]; then
  lateness=$(readlink -f "$bin/multireach-test-lateness")
  # Not by its full path: tests look for processes whose command line has $work in it.
  (cd "$work" && exec "$lateness" lateness) & disown
fi
# Whether a process of the highest priority was stopped for more than 3 ms more than once a second.
is_late_machine() {
  [ "${timed:-}" = yes ] || return 1
  local seconds late
  read -r seconds late 2>/dev/null <"$work/lateness" || return 1
  [ "$late" -gt "$seconds" ] && echo "this machine was late by more than 3 ms $late times in $seconds s"
}
finish() {
  [ $failures -gt 0 ] || { echo "all held"; exit 0; }
  [ $wrongs -gt 0 ] || ! is_late_machine || exit 75
  exit 1
}
