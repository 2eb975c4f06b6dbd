#!/usr/bin/env bash
# multireach-replay sweep: the same table with any jobs and shards, a picture of it, one sentence for what is wrong, no partial files.
#   tests/live/sweep.sh BIN_FOLDER
. "$(dirname "${BASH_SOURCE[0]}")/offline.sh"
session="$root/logs/reach.lcm"
sweep() { "$bin/multireach-replay" sweep "$session" --until 2 --set controller.gamma_rad2_m2=100,350 --set 'robot.joint_velocity_limits=[1,1,1,1],[2,2,2,2]' "$@"; }

sweep --jobs 1 -o "$work/one.csv" --json "$work/one.json" || fail "sweep"
sweep --jobs 3 >"$work/three.csv" || fail "sweep to standard output"
cmp "$work/one.csv" "$work/three.csv" || fail "one job and three give other tables"
for k in 0 1 2; do sweep --shard $k/3 --json "$work/shard$k.json" || fail "shard $k"; done
"$bin/multireach-replay" sweep merge "$work"/shard{2,0,1}.json -o "$work/merged.csv" --json "$work/merged.json" || fail "merge"
cmp "$work/one.csv" "$work/merged.csv" || fail "the merged table is not that of the whole"
cmp "$work/one.json" "$work/merged.json" || fail "the merged result is not the whole"
[ "$(wc -l <"$work/one.csv")" -eq 5 ] || fail "four combinations do not give four rows"
grep -qF '2,350,"[1,1,1,1]",' "$work/one.csv" || fail "row 2 is not that of its values"

# `run` with the same values computes the same messages, and verify accepts them with these values only.
values=(--set controller.gamma_rad2_m2=350 --set 'robot.joint_velocity_limits=[1,1,1,1]')
digest=$("$bin/multireach-replay" run "$session" --until 2 "${values[@]}" -o "$work/run.lcm" | awk '$1 == "all" { print $2 }')
grep -q "^2,.*,$digest\$" "$work/one.csv" || fail "run has the digest $digest, another than row 2"
"$bin/multireach-replay" verify "$work/run.lcm" "${values[@]}" >/dev/null || fail "the run does not verify"
"$bin/multireach-replay" verify "$work/run.lcm" >/dev/null && fail "the run verifies with other values, too"

if command -v gnuplot >/dev/null; then
  "$root/tools/sweep_picture.sh" "$work/one.csv" -o "$work/sweep.svg" || fail "no picture"
  [ "$(grep -c 'robot.joint_velocity_limits' "$work/sweep.svg")" -ge 2 ] || fail "the picture has no line for each value"
  refuses "is not the table of a sweep" "$root/tools/sweep_picture.sh" "$root/README.md" -o "$work/none.svg"
  refuses "has no column 'nothing'" "$root/tools/sweep_picture.sh" "$work/one.csv" -o "$work/none.svg" nothing
fi

refuses "'controller.gamma_rad2_m2' is 'many'; expected a number" "$bin/multireach-replay" sweep "$session" --set controller.gamma_rad2_m2=100,many
refuses "key 'controller.gamma' is not known" "$bin/multireach-replay" sweep "$session" --set controller.gamma=100
refuses "'camera.rate' is no key of a replay" "$bin/multireach-replay" sweep "$session" --set camera.rate=100
refuses "expected KEY=VALUE" "$bin/multireach-replay" sweep "$session" --set controller.gamma_rad2_m2
refuses "--set is missing" "$bin/multireach-replay" sweep "$session"
refuses "SESSION is missing" "$bin/multireach-replay" sweep --set controller.gamma_rad2_m2=1
refuses "expected i/n" sweep --shard 3/3
refuses "only 2 of the 3 shards" "$bin/multireach-replay" sweep merge "$work/shard0.json" "$work/shard2.json"
refuses "is a whole sweep" "$bin/multireach-replay" sweep merge "$work/one.json"
refuses "is not a result" "$bin/multireach-replay" sweep merge "$root/.clang-format"
refuses "named for two outputs" sweep -o - --json -
ends_with 1 "/dev/full" sweep -o /dev/full

# Interrupted, it leaves no file.
for signal in INT TERM; do
  env --default-signal=INT "$bin/multireach-replay" sweep "$session" --set controller.gamma_rad2_m2="$(seq -s, 100 400)" -o "$work/killed.csv" --json "$work/killed.json" &
  sleep 1
  kill -$signal $!
  wait $! 2>/dev/null && fail "the sweep ended in spite of signal $signal"
  compgen -G "$work/killed*" && fail "after $signal these files are left"
done
exit $failed
