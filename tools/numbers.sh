#!/usr/bin/env bash
# Measures the tables of docs/: runs the command of each, writes what it prints to docs/results/NAME.md, with the date and the computer, and
# fills in the pages. Where an arm of ../shared/robots is missing, its table stays as it is. Builds what it needs in build/bench.
#   tools/numbers.sh [NAME...]     default: those that take less than two minutes on two idle processors
#   tools/numbers.sh NAME -- WORD...   one table, with more arguments for its command, e.g. fewer reaches; the file has the whole command
#   tools/numbers.sh --built NAME...   with the programs that are in build/bench, without building them
#   tools/numbers.sh --fill        only fills in the pages from docs/results
#   tools/numbers.sh --list        the names, each with its command
# Names: @NAMES@
# Times depend on the computer and on what else it does; docs/numbers.md says which tables have times.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
build=build/bench
loop="multireach-vision multireach-controller multireach-bridge multireach-robot-sim multireach-view multireach-log multireach-robot"
names=() short=()
declare -A titles commands targets

# table NAME short|long TITLE TARGETS COMMAND: the command finds the programs in its PATH; without targets it builds what it runs.
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
table step short "Steps and batches" multireach-bench-step "bench/run.sh"
table ik long "Inverse kinematics" multireach-bench-ik "multireach-bench-ik"
table reaches long "Millions of reaches" multireach-study "tests/full/reaches.sh $build/bin"
table replay short "Replay and logs" multireach-bench-replay "multireach-bench-replay --repetitions 15"
table vision-times long "Time of vision" multireach-bench-vision "tools/bench_tables.py vision-times"
table accuracy long "Errors of vision" multireach-bench-accuracy "tools/bench_tables.py accuracy"
table tags long "Errors of tags" multireach-table-tests "tools/bench_tables.py tags"
table moebius short "Objects of the pair Moebius" multireach-table-tests "tools/bench_tables.py moebius"
table calibration short "Calibration from photographs" multireach-calibrate "tools/bench_tables.py calibration"
table stops long "Stops and restarts" "$loop multireach-camera multireach-replay multireach-publish multireach-test-garbage multireach-test-forger" "tests/live/stalls.sh $build/bin --all"
table lateness long "Lateness of ticks" "$loop" "tests/full/jitter.sh $build/bin"
table lateness-reserved long "Lateness of ticks on a reserved processor" "$loop" "tests/full/jitter.sh $build/bin --ticks 1000000 --reserve"
table drivers long "Drivers and emulators" "" "bench/robots.sh"
table page long "What the page costs" "" "bench/page.sh"
table first-command long "The first command" "" "tools/launch.sh --isolated 2>&1 | sed -n '/^position/,\$p'"

wrong() { echo "numbers.sh: $*" >&2; exit 2; }
fill() { /usr/bin/python3 tools/page_tables.py; }
chosen=() more=() built=no
while [ $# -gt 0 ]; do
  word=$1; shift
  case "$word" in
    --help|-h) sed -n '2,10p' "$0" | cut -c3- | sed "s/@NAMES@/${names[*]}/"; exit 0 ;;
    --list) for name in "${names[@]}"; do printf '%s\t%s\n' "$name" "${commands[$name]}"; done; exit 0 ;;
    --fill) fill; exit 0 ;;
    --built) built=yes ;;
    --) [ ${#chosen[@]} -eq 1 ] || wrong "-- expects one table before it"; more=("$@"); break ;;
    -*) wrong "unknown option '$word'; see --help" ;;
    *) [ -n "${commands[$word]+is}" ] || wrong "unknown table '$word'; expected one of: ${names[*]}"; chosen+=("$word") ;;
  esac
done
[ ${#chosen[@]} -gt 0 ] || chosen=("${short[@]}")

# version_text: the version of the project, with its last commit.
version_text() {
  sed -n 's/^project(multireach VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt | tr -d '\n'
  printf ' of %s, commit %s' "$(git log -1 --format=%cs)" "$(git rev-parse --short HEAD)"
  git diff --quiet HEAD -- . ':!docs' || echo ", with changes"
}

# measure NAME: writes its file; the status of its command.
measure() {
  local begin load status=0 command=${commands[$1]}
  # These programs leave out the arms that are not here.
  case "$1" in longest-steps|ik|laws) [ -d ../shared/robots ] || { echo "numbers.sh: the arms of ../shared/robots are not here" >&2; return 1; } ;; esac
  [ ${#more[@]} -eq 0 ] || command+=$(printf ' %q' "${more[@]}")
  begin=$(date +%s) load=$(cut -d' ' -f1 /proc/loadavg)
  bash -o pipefail -c "$command" >"$work/$1" || status=$?
  [ $status -eq 0 ] || return $status
  { echo "# ${titles[$1]}"
    echo
    echo "- Command: \`$command\`"
    echo "- Measured: $(date -d "@$begin" +%F), in $(($(date +%s) - begin)) s; load average $load before, $(cut -d' ' -f1 /proc/loadavg) after"
    echo "- Version: $version"
    echo "- Computer: $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1), $(nproc) processors"
    echo "- Compiler: $(grep '^CMAKE_CXX_COMPILER:' "$build/CMakeCache.txt" | cut -d= -f2 | xargs -I{} sh -c '{} --version' | head -1)"
    echo
    # Text outside of tables stays as it is.
    if grep -q '^|' "$work/$1"; then cat "$work/$1"; else echo '```text'; cat "$work/$1"; echo '```'; fi; } | cat -s | sed '$ { /^$/ d }' >"$work/$1.md"
  mv "$work/$1.md" "docs/results/$1.md"
  echo "docs/results/$1.md"
}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
version=$(version_text)
if [ $built = no ]; then
  cmake --preset release -B "$build" -DMULTIREACH_BENCH=ON -DMULTIREACH_TESTS=ON -DMULTIREACH_PYTHON=ON >/dev/null
  needed=()
  for name in "${chosen[@]}"; do read -ra words <<<"${targets[$name]}"; needed+=("${words[@]}"); done
  [ ${#needed[@]} -eq 0 ] || cmake --build "$build" --target "${needed[@]}" >/dev/null
fi
export PATH="$root/$build/bin:$PATH" PYTHONPATH="$root/$build/python"
failed=0
for name in "${chosen[@]}"; do
  measure "$name" || { echo "numbers.sh: $name: its table stays as it is" >&2; failed=1; }
done
fill
exit $failed
