#!/usr/bin/env bash
# Runs the benchmarks of steps, which it builds where they are not in PATH, several times, and prints the best of each as two tables of docs/benchmarks.md, with ratios
# within the run.
#   bench/run.sh [REPETITIONS]     default 9
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
program=$(command -v multireach-bench-step || true)  # tools/numbers.sh has built it
if [ -z "$program" ]; then
  cmake --preset release -B build/bench -DMULTIREACH_BENCH=ON >/dev/null
  cmake --build build/bench --target multireach-bench-step >/dev/null
  program=build/bench/bin/multireach-bench-step
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for _ in $(seq "${1:-9}"); do
  "$program" --benchmark_min_time=0.2 --benchmark_format=csv >>"$work/runs.csv" 2>/dev/null
done
awk -F, '
  /^"/ { name = $1; gsub(/"/, "", name)
         if (!(name in best) || $4 < best[name]) best[name] = $4
         if ($NF != "" && (!(name in tail) || $NF < tail[name])) tail[name] = $NF
         if (!(name in seen)) { seen[name] = 1; order[++n] = name } }
  function beside(name, other, what) { return (other in best) ? sprintf("1/%.1f%s", best[other] / best[name], what) : "" }
  END {
    print "## Step\n\n| what | ns | 99.9th percentile, ns | of the reference implementation |\n|---|---|---|---|"
    for (i = 1; i <= n; ++i) {
      name = order[i]; arm = name; sub(/.*\//, "", arm); ratio = last = ""
      if (name ~ /_batch\/|fixed/) continue
      if (name ~ /^guarded_step\//) {
        ratio = beside(name, "plain_step/" arm, " of plain Eigen")
        ratio = ratio (ratio != "" && ("kdl_lma/" arm) in best ? ", " : "") beside(name, "kdl_lma/" arm, " of KDL LMA") beside(name, "kdl_wdls/" arm, " of KDL wdls")
      }
      if (name in tail) last = sprintf("%.0f", tail[name])
      printf "| %s | %.0f | %s | %s |\n", name, best[name], last, ratio
    }
    print "\n## Batches\n\n| what | ns | of plain Eigen | of fixed-size Eigen |\n|---|---|---|---|"
    for (i = 1; i <= n; ++i) {
      name = order[i]; arm = name; sub(/.*\//, "", arm)
      if (name ~ /_batch\//) sub(/_[^_]*$/, "", arm)
      if (arm !~ /_m3$/ || name ~ /kdl|obstacles/) continue
      own = name ~ /^(guarded|paper)/
      printf "| %s | %.4g | %s | %s |\n", name, best[name], own ? beside(name, "plain_step/" arm, "") : "", own ? beside(name, "plain_fixed_step/" arm, "") : ""
    }
  }' "$work/runs.csv"
