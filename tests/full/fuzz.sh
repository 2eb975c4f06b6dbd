#!/usr/bin/env bash
# libFuzzer, with the sanitizers, on the readers of messages, URDFs, configuration and logs: RUNS inputs each (default 200000; of
# logs, which take longer, a tenth), from seeds of the project. A finding leaves its input in the working folder.
#   tests/full/fuzz.sh BIN [RUNS]
set -uo pipefail
bin=$1 runs=${2:-200000}
root=$(cd "$(dirname "$0")/../.." && pwd)
seeds=$(mktemp -d)
trap 'rm -rf "$seeds"' EXIT
mkdir "$seeds"/{messages,urdf,yaml,log}
cp "$root"/robots/*/*.urdf "$seeds/urdf"
cp "$root"/robots/*/*.yaml "$root"/logs/*.yaml "$seeds/yaml"
head -c 65536 "$root/logs/reach.lcm" >"$seeds/log/reach.lcm"
head -c 65536 "$root/logs/damaged.lcm" >"$seeds/log/damaged.lcm"
failed=0
for name in messages urdf yaml log; do
  number=$runs
  [ $name != log ] || number=$((runs / 10))
  echo "fuzzing $name, $number inputs"
  "$bin/multireach-fuzz-$name" -runs=$number -seed=14 -max_len=70000 -timeout=20 -rss_limit_mb=3000 -print_final_stats=1 \
    "$seeds/$name" >"$seeds/out" 2>&1 || { failed=1; tail -40 "$seeds/out"; echo "fuzz.sh: $name failed" >&2; }
  grep -E '^stat::(number_of_executed_units|average_exec_per_sec|peak_rss_mb)' "$seeds/out"
done
exit $failed
