#!/usr/bin/env bash
# multireach-study: the same numbers with any threads and shards; a sample traced again; unusable input in one sentence.
#   tests/live/study.sh BIN_FOLDER
. "$(dirname "${BASH_SOURCE[0]}")/offline.sh"
arm=(--urdf "$root/robots/hoap2/hoap2.urdf" --base torso --tip right_hand)
study() { "$bin/multireach-study" "${arm[@]}" --samples 600 --gamma 100,1000 "$@"; }
# All but the shard's name and the time that it took.
numbers() { sed -e '/"ns_per_step_per_core"/d' -e '/"shard"/d' "$1"; }
same() { diff <(numbers "$1") <(numbers "$2") >"$work/diff" || { fail "$3"; head -n 5 "$work/diff"; }; }

for law in guarded paper; do
  study --law "$law" --threads 1 --json "$work/one.json" || fail "study of $law"
  study --law "$law" --threads 3 --json "$work/three.json"
  same "$work/one.json" "$work/three.json" "$law: one thread and three give other numbers"
  for k in 0 1 2; do study --law "$law" --shard $k/3 --json "$work/shard$k.json"; done
  "$bin/multireach-study" merge "$work"/shard{0,1,2}.json --json "$work/merged.json" || fail "merge"
  same "$work/one.json" "$work/merged.json" "$law: the merged shards are not the whole"
  study --law "$law" --seed 2 --json "$work/other.json"
  diff -q <(numbers "$work/one.json") <(numbers "$work/other.json") >"$work/diff" && fail "the seed changes nothing"
done

# What trace-sample prints, run again, ends at the target.
study --trace-sample 17 >"$work/commands"
[ "$(wc -l <"$work/commands")" -eq 2 ] || fail "two values of gamma give two commands"
while read -r command; do
  (cd "$bin" && eval "./$command -o $work/trace.csv") || fail "$command"
  target=$(sed 's/.*--target=\([^ ]*\) .*/\1/' <<<"$command")
  tail -n 1 "$work/trace.csv" | awk -F, -v t="$target" '{ split(t, p, ","); exit !(($6 - p[1])^2 + ($7 - p[2])^2 + ($8 - p[3])^2 < 1e-8) }' ||
    fail "the traced reach does not arrive: $command"
done <"$work/commands"

# A reach that fails in the study is the one that the trace shows, however chaotic the law: step for step the same, to the last.
study --law paper --failures "$work/failures.csv" --json "$work/failing.json"
IFS=, read -r gamma index error _ < <(sed -n 2p "$work/failures.csv")
[ "$(wc -l <"$work/failures.csv")" -eq "$(awk '/"failures"/ { sum += $2 } END { print sum + 1 }' "$work/failing.json")" ] || fail "--failures does not list every failure"
command=$("$bin/multireach-study" "${arm[@]}" --law paper --gamma "$gamma" --trace-sample "$index")
(cd "$bin" && eval "./$command -o $work/trace.csv") || fail "$command"
target=$(sed 's/.*--target=\([^ ]*\) .*/\1/' <<<"$command")
awk -F, -v t="$target" -v e="$error" 'BEGIN { split(t, p, ",") }
  NR > 1 { d = sqrt(($6 - p[1])^2 + ($7 - p[2])^2 + ($8 - p[3])^2) - e; if (d < 1e-14 && d > -1e-14) found = 1 }
  END { exit !found }' "$work/trace.csv" || fail "the trace of reach $index never has the error of the study, $error"

# --drift 0 means never in both programs.
read -r never < <("$bin/multireach-study" "${arm[@]}" --law paper --gamma 100 --drift 0 --trace-sample 3)
[[ "$never" == *"--drift 0 "* ]] || fail "the command does not say so: $never"
(cd "$bin" && eval "./$never -o $work/trace.csv") || fail "$never"
"$bin/multireach-study" "${arm[@]}" --law paper --gamma 350 --drift 0 --samples 600 --json "$work/never.json"
"$bin/multireach-study" "${arm[@]}" --law paper --gamma 350 --drift 1e6 --samples 600 --json "$work/far.json"
diff <(numbers "$work/never.json" | grep -v drift) <(numbers "$work/far.json" | grep -v drift) >/dev/null || fail "0 is not never"

# Straightness: a table, and the same numbers with any threads.
straight() { "$bin/multireach-study" straightness "${arm[@]}" --samples 20 --nodes 200 "$@"; }
straight --threads 1 --json "$work/straight1.json" >"$work/straight.txt" || fail "straightness"
straight --threads 3 --json "$work/straight3.json" >/dev/null
cmp "$work/straight1.json" "$work/straight3.json" || fail "straightness: one thread and three give other numbers"
[ "$(grep -c '^| all | ' "$work/straight.txt")" -eq 4 ] || fail "the table of straightness has not four ways"
# Moving targets and throws: a table, and the same numbers again.
panda=(--urdf "$root/robots/panda/panda.urdf" --base panda_link0 --tip panda_hand)
for run in 1 2; do
  "$bin/multireach-study" tracking "${panda[@]}" --samples 1 --seed 7 >"$work/tracking$run.txt" || fail "tracking"
  "$bin/multireach-study" throws "${panda[@]}" --samples 3 --seed 9 >"$work/throws$run.txt" || fail "throws"
done
for motion in tracking throws; do
  cmp "$work/${motion}1.txt" "$work/${motion}2.txt" || fail "$motion: two runs give other numbers"
  grep -q '^| .*[0-9]' "$work/${motion}1.txt" || fail "the table of $motion has no row: $(cat "$work/${motion}1.txt")"
done
refuses "--urdf is missing" "$bin/multireach-study" straightness --base a --tip b

refuses "outside 0 to 1e12" "$bin/multireach-study" "${arm[@]}" --gamma=100,-5
refuses "--gamma" "$bin/multireach-study" "${arm[@]}" --gamma=many
refuses "not positive" "$bin/multireach-study" "${arm[@]}" --acceleration=-1
refuses "one for each of the 4 joints" "$bin/multireach-study" "${arm[@]}" --acceleration=1,2
refuses "'0' has a value that is not positive" "$bin/multireach-study" "${arm[@]}" --joint-weights=0
refuses "does not go with --joint-weights" "$bin/multireach-study" "${arm[@]}" --joint-weights=1 --trace-sample 1
refuses "expected i/n" "$bin/multireach-study" "${arm[@]}" --shard 3/3
refuses "nothing.urdf" "$bin/multireach-study" --urdf nothing.urdf --base a --tip b
refuses "--urdf is missing" "$bin/multireach-study" --base a --tip b
study --seed 2 --shard 1/3 --json "$work/other.json"
refuses "is a whole study" "$bin/multireach-study" merge "$work/one.json"
refuses "of another study" "$bin/multireach-study" merge "$work/shard0.json" "$work/other.json"
refuses "shard 0 once more" "$bin/multireach-study" merge "$work/shard0.json" "$work/shard0.json"
refuses "only 2 of the 3 shards" "$bin/multireach-study" merge "$work/shard0.json" "$work/shard2.json"
echo "{}" >"$work/empty.json"
refuses "is not a result" "$bin/multireach-study" merge "$work/empty.json"
ends_with 1 "/dev/full" "$bin/multireach-study" "${arm[@]}" --samples 10 --csv /dev/full --json /dev/null
sed 's/lower="[^"]*" upper="[^"]*"/lower="0" upper="0"/' "$root/robots/hoap2/hoap2.urdf" >"$work/stiff.urdf"
refuses "it cannot move" "$bin/multireach-study" --urdf "$work/stiff.urdf" --base torso --tip right_hand

# Killed in the middle it leaves no file.
"$bin/multireach-study" "${arm[@]}" --samples 100000000 --json "$work/killed.json" &
sleep 1
kill $!
wait $! 2>/dev/null
[ -z "$(ls "$work" | grep killed)" ] || fail "a killed study leaves $(ls "$work" | grep killed)"
exit $failed
