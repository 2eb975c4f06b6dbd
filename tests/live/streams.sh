# shellcheck shell=bash disable=SC2154
# Sourced by scripts that check the streams of a recorded run: of each bridge's commands, of each robot's states.
# streams_of LIST REPORT: the entries of command_streams or robot_streams in a report, a line each.
streams_of() { tr -d ' \n' <"$2" | grep -o "\"$1\":\[[^]]*" | grep -o '{[^}]*}'; }
# runs_in LOG ROBOT: the runs of the bridges and robots in a log.
runs_in() {
  "$bin/multireach-log" report "$1" --robot "$2" --json "$work/runs.json" >/dev/null 2>&1
  { streams_of command_streams "$work/runs.json"; streams_of robot_streams "$work/runs.json"; } | grep -o '"run":[0-9]*' | cut -d: -f2
}
# largest_share LIST LIMIT REPORT [RUN...]: the largest share of a limit (speed, acceleration, jerk) in the streams of a report, but for
# those of the given runs: of an old log that was played beside, which no robot obeyed.
largest_share() {
  local list=$1 limit=$2 report=$3 run others=none
  shift 3
  for run in "$@"; do others+=$'\n'"\"run\":$run,"; done
  # Keys of an entry are in alphabetical order.
  streams_of "$list" "$report" | sed 's/}/,}/' | grep -vF "$others" | grep -o "\"${limit}_share\":[0-9.e+-]*" | cut -d: -f2 | sort -g | tail -n1
}
