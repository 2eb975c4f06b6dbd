#!/usr/bin/env bash
# Measures the tables of docs/: runs the command of each, writes what it prints to docs/results/NAME.md, with the date and the computer, and
# fills in the pages. Where an arm of ../shared/robots is missing, its table stays as it is. Builds what it needs in build/bench.
#   tools/numbers.sh [NAME...]     default: those that take less than two minutes on two idle processors
#   tools/numbers.sh --fill        only fills in the pages from docs/results
#   tools/numbers.sh --list        the names, each with its command
# Names: @NAMES@
# Times depend on the computer and on what else it does; docs/numbers.md says which tables have times.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
build=build/bench
names=() short=()
declare -A titles commands targets

# table NAME short|long TITLE TARGET COMMAND: the command finds the programs in its PATH.
table() {
  names+=("$1") titles[$1]=$3 targets[$1]=$4 commands[$1]=$5
  [ "$2" = long ] || short+=("$1")
}
table tracking short "Targets that keep moving" multireach-study "tools/study_tables.py tracking"
table throws long "Thrown balls" multireach-study "tools/study_tables.py throws"
table straightness long "The path of the hand" multireach-study "tools/study_tables.py straightness"
table slow-joints short "Slow joints" multireach-study "tools/study_tables.py slow-joints"
table laws short "The same reaches under other laws" multireach-bench-laws "multireach-bench-laws"
table longest-steps short "The longest steps" multireach-bench-worst "multireach-bench-worst --reaches 40 --passes 3"
table python short "Calls from Python" multireach_python "/usr/bin/python3 bench/python_bench.py"

wrong() { echo "numbers.sh: $*" >&2; exit 2; }
fill() { /usr/bin/python3 tools/page_tables.py; }
chosen=()
for word in "$@"; do
  case "$word" in
    --help|-h) sed -n '2,8p' "$0" | cut -c3- | sed "s/@NAMES@/${names[*]}/"; exit 0 ;;
    --list) for name in "${names[@]}"; do printf '%s\t%s\n' "$name" "${commands[$name]}"; done; exit 0 ;;
    --fill) fill; exit 0 ;;
    -*) wrong "unknown option '$word'; see --help" ;;
    *) [ -n "${commands[$word]+is}" ] || wrong "unknown table '$word'; expected one of: ${names[*]}"; chosen+=("$word") ;;
  esac
done
[ ${#chosen[@]} -gt 0 ] || chosen=("${short[@]}")

# version_text: the version of the project, and the day of its last commit.
version_text() {
  sed -n 's/^project(multireach VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt | tr -d '\n'
  git log -1 --format=' of %cs' | tr -d '\n'
  git diff --quiet HEAD -- . ':!docs' || echo ", with changes"
}

# measure NAME: writes its file; the status of its command.
measure() {
  local begin load status=0
  begin=$(date +%s) load=$(cut -d' ' -f1 /proc/loadavg)
  bash -c "${commands[$1]}" >"$work/$1" || status=$?
  [ $status -eq 0 ] || return $status
  { echo "# ${titles[$1]}"
    echo
    echo "- Command: \`${commands[$1]}\`"
    echo "- Measured: $(date -d "@$begin" +%F), in $(($(date +%s) - begin)) s; load average $load before, $(cut -d' ' -f1 /proc/loadavg) after"
    echo "- Version: $version"
    echo "- Computer: $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1), $(nproc) processors"
    echo "- Compiler: $(grep '^CMAKE_CXX_COMPILER:' "$build/CMakeCache.txt" | cut -d= -f2 | xargs -I{} sh -c '{} --version' | head -1)"
    echo
    cat "$work/$1"; } | cat -s | sed '$ { /^$/ d }' >"$work/$1.md"
  mv "$work/$1.md" "docs/results/$1.md"
  echo "docs/results/$1.md"
}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --preset release -B "$build" -DMULTIREACH_BENCH=ON -DMULTIREACH_TESTS=OFF -DMULTIREACH_PYTHON=ON >/dev/null
needed=()
for name in "${chosen[@]}"; do needed+=("${targets[$name]}"); done
version=$(version_text)
cmake --build "$build" --target "${needed[@]}" >/dev/null
export PATH="$root/$build/bin:$PATH" PYTHONPATH="$root/$build/python"
failed=0
for name in "${chosen[@]}"; do
  measure "$name" || { echo "numbers.sh: $name: its table stays as it is" >&2; failed=1; }
done
fill
exit $failed
