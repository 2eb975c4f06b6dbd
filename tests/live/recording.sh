# Sourced after namespace.sh by tests that record what a camera sends; they then are in the folder $work.
video="$bin/multireach-test-video"
images='udpm://239.255.76.68:7668?ttl=0&recv_buf_size=4194304' control='udpm://239.255.76.67:7667?ttl=0'
cd "$work" || exit 1

# What is sent in between is in NAME.lcm (images) and NAME.control.lcm.
begin_recording() {
  lcm-logger --lcm-url="$images" --force --quiet "$1.lcm" >/dev/null 2>&1 & loggers=$!
  lcm-logger --lcm-url="$control" --force --quiet "$1.control.lcm" >/dev/null 2>&1 & loggers="$loggers $!"
  sleep 0.3
}
end_recording() {
  sleep 0.1
  kill -INT $loggers; wait $loggers 2>/dev/null
}
# record NAME COMMAND...: what the command sends, and what it says, in NAME.err.
record() {
  local name=$1; shift
  begin_recording "$name"
  timeout 10 "$@" 2>"$name.err"
  local code=$?
  end_recording
  return $code
}
pairs() { "$bin/multireach-log" info "$1.lcm" | awk '$1 == "STEREO_IMAGES" { n = $3 } END { print n + 0 }'; }
# states NAME: what NODE_STATUS said, a line a second.
states() {
  [ -d "$1" ] || "$bin/multireach-log" export csv "$1.control.lcm" -o "$1" --channel NODE_STATUS 2>/dev/null
  cut -d'"' -f6 "$1/NODE_STATUS.csv"
}
expect_logged() { grep -qF -- "$2" "$1.err" || failed "$1: '$2' was not said: $(cat "$1.err")"; }
