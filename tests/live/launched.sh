# shellcheck shell=bash disable=SC2034,SC2154  # variables are shared with the test that sources this
# Sourced after namespace.sh by tests of launch.sh: runs it, kills what it started, and reads its report.
[ "$bin" -ef "$root/build/release/bin" ] || { echo "skipped: launch.sh runs the release build"; exit 77; }

# launch NAME OPTION...: starts launch.sh in the background; $launched is its process. What it says is in NAME.err, its report in
# NAME.json. Returns when images are sent.
launch() {
  name=$1; shift
  rm -rf "$XDG_STATE_HOME.$name"
  XDG_STATE_HOME="$XDG_STATE_HOME.$name" "$root/tools/launch.sh" --no-setup --json "$work/$name.json" "$@" 2>"$work/$name.err" & launched=$!
  until compgen -G "$XDG_STATE_HOME.$name/multireach/runs/*/source.err" >/dev/null || ! kill -0 $launched 2>/dev/null; do sleep 0.05; done
}
# killed PATTERN: kills the process of launch.sh whose command line matches.
killed() { kill -KILL "$(pgrep -P "$launched" -f "$1" | head -n 1)" || failed "no process '$1'"; }
# ended CODE: waits for launch.sh.
ended() {
  wait "$launched"
  local code=$?
  [ $code -eq "$1" ] || failed "$name: exit code $code, expected $1: $(cat "$work/$name.err")"
}
says() { grep -qE -- "$1" "$work/$name.err" || failed "$name: does not say '$1': $(cat "$work/$name.err")"; }
# report KEY: its first value in the report of the newest run.
report() { tr -d ' \n' <"$work/$name.json" | grep -o "\"$1\":[^,}]*" | head -n1 | cut -d: -f2; }
restarts_of() { tr -d ' \n' <"$work/$name.json" | grep -o "\"$1\":{[^}]*" | grep -o '"restarts":[0-9]*' | cut -d: -f2; }
reached() { tr -d ' \n' <"$work/$name.json" | grep -o '"settle_s":[0-9]' | wc -l; }
# await_state SECONDS PATTERN: until the bridge's state matches.
await_state() {
  local _ state=""
  for _ in $(seq $((5 * $1))); do
    state=$("$bin/multireach-robot" status 2>&1)
    [[ $state =~ ^$2 ]] && return
    sleep 0.2
  done
  failed "$name: the bridge's state is '$state', not '$2'"
}
