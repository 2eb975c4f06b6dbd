#!/usr/bin/env bash
# Builds the benchmarks, runs them several times, and prints the best of each as the table of docs/benchmarks.md: absolute times,
# and ratios within the run.
#   bench/run.sh [REPETITIONS]     default 9
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
build=build/bench
cmake --preset release -B "$build" -DMULTIREACH_BENCH=ON -DMULTIREACH_TESTS=OFF >/dev/null
cmake --build "$build" --target multireach-bench-step >/dev/null
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for _ in $(seq "${1:-9}"); do
  "$build/bin/multireach-bench-step" --benchmark_min_time=0.2 --benchmark_format=csv >>"$work/runs.csv" 2>/dev/null
done
awk -F, '
  /^"/ { name = $1; gsub(/"/, "", name)
         if (!(name in best) || $4 < best[name]) best[name] = $4
         if ($NF != "" && (!(name in tail) || $NF < tail[name])) tail[name] = $NF
         if (!(name in seen)) { seen[name] = 1; order[++n] = name } }
  END {
    print "| what | ns | 99.9th percentile, ns | of the reference implementation |"; print "|---|---|---|---|"
    for (i = 1; i <= n; ++i) {
      name = order[i]; arm = name; sub(/.*\//, "", arm); ratio = ""
      if (name ~ /^guarded_step\//) {
        if (("plain_step/" arm) in best) ratio = sprintf("1/%.1f of plain Eigen", best["plain_step/" arm] / best[name])
        if (("kdl_lma/" arm) in best) ratio = ratio sprintf(", 1/%.0f of KDL LMA", best["kdl_lma/" arm] / best[name])
        if (("kdl_wdls/" arm) in best) ratio = ratio sprintf("1/%.1f of KDL wdls", best["kdl_wdls/" arm] / best[name])
      }
      if (name ~ /_batch\//) {
        sub(/_[^_]*$/, "", arm)
        ratio = sprintf("1/%.1f of plain Eigen, 1/%.1f of fixed-size Eigen", best["plain_step/" arm] / best[name], best["plain_fixed_step/" arm] / best[name])
      }
      last = ""
      if (name in tail) last = sprintf("%.0f", tail[name])
      printf "| %s | %.0f | %s | %s |\n", name, best[name], last, ratio
    }
  }' "$work/runs.csv"
