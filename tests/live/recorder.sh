#!/usr/bin/env bash
# The recording survives when its recorders are killed, and when launch.sh is.
bin=$1
timed=yes
. "$(dirname "$0")/namespace.sh"
. "$root/tests/live/launched.sh"
log="$bin/multireach-log"

# Recorders that are killed: launch.sh starts others and merges what all of them wrote.
launch recorders --record "$work/run.lcm" --seconds 9
sleep 2; killed 'lcm-logger.*control'
sleep 2; killed 'lcm-logger.*images'
sleep 1; killed 'lcm-logger.*control.1'
ended 0
says '^restarts: control_log 2, image_log 1$'
# Only what was sent while no recorder ran, and what the killed one had not written, is missing: less than a second of each channel.
for channel in JOINT_COMMAND:1000 TARGET:30 STEREO_IMAGES:30; do
  read -r events lost < <("$log" info "$work/run.lcm" | awk -v c="${channel%:*}" '$1 == c { print $3, $7 }')
  hz=${channel#*:}
  if [ "$events" -le $((6 * hz)) ] || [ "$lost" -ge "$hz" ]; then failed "${channel%:*}: $events recorded, $lost lost"; fi
done

# launch.sh is killed: the parts stay, and the commands that it prints finish them.
launch killed --record "$work/killed.lcm"
sleep 3; killed 'lcm-logger.*control'
sleep 4; kill -KILL $launched; wait $launched 2>/dev/null
for _ in $(seq 50); do pgrep -f "$XDG_STATE_HOME.killed" >/dev/null || break; sleep 0.1; done
[ ! -e "$work/killed.lcm" ] || wrong "a recording that nobody has finished is there"
"$root/tools/launch.sh" --no-setup --session "$work/none" 2>"$work/killed.err" && wrong "a session that is not there"
XDG_STATE_HOME="$XDG_STATE_HOME.killed" "$root/tools/launch.sh" --no-setup --seconds 1 2>"$work/killed.err"
says "^launch.sh: an earlier run was killed; its recording is in $XDG_STATE_HOME.killed/multireach/runs/[^ ]*\. To finish it:"
sed -n 's/^  \(tools.*\|rm .*\)/\1/p' "$work/killed.err" | sed "s| run.lcm| $work/finished.lcm|; s|^tools/multireach |$root/tools/multireach |" >"$work/finish"
[ "$(wc -l <"$work/finish")" -eq 3 ] || failed "not three commands: $(cat "$work/finish")"
bash -e "$work/finish" 2>"$work/killed.err" || failed "its commands fail: $(cat "$work/killed.err")"
says '^ 0.100 -0.120  0.100  '
[ -z "$(ls "$XDG_STATE_HOME.killed/multireach/runs")" ] || failed "left over: $(ls "$XDG_STATE_HOME.killed/multireach/runs")"
finish
