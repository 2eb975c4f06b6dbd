# Sourced by the scripts of this folder: runs the calling script again in a network namespace of its own, so that no message
# leaves the test, or skips it (exit code 77) where that is not allowed.
if [ -z "${MULTIREACH_ISOLATED:-}" ]; then
  user=()
  [ "$(id -u)" -eq 0 ] || user=(--map-root-user)
  if ! unshare "${user[@]}" --net true 2>/dev/null; then
    echo "skipped: a network namespace cannot be made here"
    exit 77
  fi
  export MULTIREACH_ISOLATED=1
  exec unshare "${user[@]}" --net -- sh -c 'ip link set lo up && ip route add 224.0.0.0/4 dev lo && exec "$0" "$@"' "$0" "$@"
fi
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
work=$(mktemp -d)
export XDG_STATE_HOME="$work/state"  # unfinished recordings of launch.sh
trap 'rm -rf "$work"' EXIT
failures=0
failed() { echo "FAILED: $1"; failures=$((failures + 1)); }
finish() {
  [ $failures -eq 0 ] && echo "all held"
  exit $((failures > 0))
}
