#!/usr/bin/env bash
# All tests, from a clean clone: installs what is missing, builds, and runs
#   - the format of the code, ShellCheck on the scripts, the pages with their links, and the API pages of the headers,
#   - the release build: unit tests, and whole processes in network namespaces of their own,
#   - the stages alone, as on a machine without LCM, and a program that uses them as an installed package,
#   - the stages by Clang, warnings as errors, with the address and undefined-behaviour sanitizers: unit tests, without those that take long there.
# --full adds those, everything else with these sanitizers, the drivers of the other arms, the set-up course in a browser, clang-tidy, a release build by
# Clang, the thread sanitizer, 10^7 fuzzed calls, libFuzzer on the readers of files and messages, 10^6 damaged logs, a thousand random arms, a thousand
# changed bytes, studies on many machines, an hour of the whole system, the Debian packages in a clean system, and the studies of docs/guarantees.md (half
# an hour).
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root" || exit 1
full=no
case "${1:-}" in
  "") ;;
  --full) full=yes ;;
  --help|-h) sed -n '2,10p' "$0" | cut -c3-; exit 0 ;;
  *) echo "test.sh: unknown option '$1'; see --help" >&2; exit 2 ;;
esac

# Of the stages, what takes more than a quarter of a minute with the sanitizers; --full runs it.
slow_with_sanitizers='^SphereContourFit[.](ABallThatMoves|ABallThatTheBorder|AStripedBall|CovarianceIsThat|IsExactTo|OfAJpeg|TheCovarianceOf|WhatMayBeHidden)'
slow_with_sanitizers+='|^EveryInstructionSet[.](GivesTheBits|TakesTheSteps)|^SearchInSlices[.]FindsWhat|^BridgeFaults[.]EverySchedule|^Find[.]KeepsItsMemory'
slow_with_sanitizers+='|^GuardedLaw[.](ArrivesInside|TakesShorter|RestsAsNear|TurnsTheHand)|^MultiStartIk[.]NoSolution|^Light[.]WhiteBalance'
slow_with_sanitizers+='|^PathPlanner[.]ItsPath|^PaperLaw[.]AgreesWith|^IntegrationRate[.]TheHand|^PathOptimizer[.]FindsALocalMinimum'
# A clone in another folder reuses what the compiler cache holds of this one.
export CCACHE_BASEDIR=$root CCACHE_NOHASHDIR=1
declare -a results=()
failed=0
details=""
# stage NAME COMMAND...: runs a command and records whether it passed.
stage() {
  local name=$1 begin=$SECONDS; shift
  printf '\n=== %s\n' "$name"
  if "$@"; then
    results+=("passed  $((SECONDS - begin)) s  $name")
  else
    results+=("FAILED  $((SECONDS - begin)) s  $name")
    failed=$((failed + 1))
  fi
}
sources() { git ls-files '*.cpp' '*.hpp'; }
format() { sources | xargs clang-format --dry-run --Werror; }
scripts() { shellcheck tools/*.sh tools/multireach web/build.sh docs/pictures/{view,reach}.sh cmake/debian/{postinst,postrm,prerm} cmake/debian/python/prerm tests/package/run.sh tests/full/{debian_package,many_machines}.sh tests/live/{launched,supervision,recorder,stacks,two_hosts,systemd_units,doctor,view_page,keys}.sh; }
# tests PRESET OPTION...: runs tests by ctest; for the end of this script's output, keeps the last lines of those that failed, also in a
# first run of two.
tests() {
  local code text
  ctest --preset "$@"
  code=$?
  text=$(awk '
    /^[0-9]+\/[0-9]+ Testing: / { name = $0; sub(/^[^:]*: /, "", name); count = 0 }
    { line[++count] = $0 }
    /^Test (Failed|Timed Out|timed out)/ { printf "\n%s:\n", name; for (i = count > 30 ? count - 30 : 7; i < count; ++i) print "    " line[i] }
  ' "build/$1/Testing/Temporary/LastTest.log")
  details+=$text
  return "$code"
}
unit_tests() { tests "$@" --label-regex unit --parallel 2 --progress; }
# Whole processes in real time, on a machine that may be busy: a test that fails is run once more, and ctest says so.
live_tests() { tests release --label-regex live --repeat until-pass:2; }
build() { cmake --preset "$1" >/dev/null && cmake --build --preset "$1" --target unit_tests; }
build_and_test() { build "$1" && unit_tests "$@"; }
fuzz() { MULTIREACH_FUZZ_CALLS=10000000 build/asan/bin/multireach_stage_tests --gtest_filter='Fuzz.*'; }
fuzzers() { cmake --build --preset asan --target fuzzers && tests/full/fuzz.sh build/asan/bin; }
altered_messages() { MULTIREACH_ALTERED_MESSAGES=1000000 build/release/bin/multireach_runtime_tests --gtest_filter='TaggedMessage.*'; }
damaged_logs() { MULTIREACH_LOG_MUTATIONS=1000000 build/release/bin/multireach_runtime_tests --gtest_filter='LogFuzz.*'; }
odd_arms() { MULTIREACH_ODD_ARMS=1000 build/release/bin/multireach_stage_tests --gtest_filter='*OddArms*'; }
changed_bytes() { MULTIREACH_CHANGES=1000 MULTIREACH_CHANGED_LOG=$root/logs/load.lcm build/release/bin/multireach_runtime_tests --gtest_filter='*EveryChangedByte*'; }
# Exit code 77: skipped, and why.
page_test() { "tests/live/$1.sh" "$PWD/build/release/bin" || [ $? -eq 77 ]; }
debian_packages() {
  if [ "$(id -u)" -eq 0 ] && command -v mmdebstrap >/dev/null; then tests/full/debian_package.sh
  else echo "skipped: this needs root, and the Debian package mmdebstrap"; fi
}
# Exit code 77: skipped, and why.
many_machines() { tests/full/many_machines.sh build/release/bin || [ $? -eq 77 ]; }
# With the flags and the generated headers of the build by Clang. tests/package is a project of its own, and the Python module not in that build.
tidy() { sources | grep '\.cpp$' | grep -vE '^(tests/package|python)/' | xargs -P 2 -n 4 clang-tidy -p build/clang --quiet; }

[ -d "$root/../shared" ] || echo "skipped where needed: ../shared is not here (public arms, a real stereo pair)"
stage "build" tools/setup.sh tests
[ $failed -eq 0 ] || { echo "test.sh: the build failed" >&2; exit 1; }
stage "format" format
stage "scripts" scripts
stage "pages and their links" tools/docs.sh
stage "unit tests" unit_tests release
stage "whole processes" live_tests
stage "the stages alone" build core
stage "the installed package" tests/package/run.sh build/core
stage "the stages by Clang, with the address and undefined-behaviour sanitizers" build_and_test asan-core --exclude-regex "$slow_with_sanitizers"
if [ $full = yes ]; then
  stage "everything by Clang, with the sanitizers" build_and_test asan
  stage "Clang" build_and_test clang
  stage "clang-tidy" tidy
  stage "thread sanitizer" build_and_test tsan
  stage "10^7 fuzzed calls, with the sanitizers" fuzz
  stage "libFuzzer, with the sanitizers" fuzzers
  stage "10^6 altered messages" altered_messages
  stage "10^6 damaged logs" damaged_logs
  stage "a thousand random arms" odd_arms
  stage "a thousand changed bytes" changed_bytes
  stage "studies on many machines" many_machines
  stage "the drivers of the other arms" env MULTIREACH_DRIVERS="panda ur5" tests/live/drivers.sh "$PWD/build/release/bin"
  stage "the set-up course" page_test course_page
  stage "an hour of the whole system" tests/full/soak.sh build/release/bin
  stage "Debian packages in a clean system" debian_packages
  stage "millions of reaches" tests/full/reaches.sh build/release/bin
fi

[ -z "$details" ] || printf '\nThe last lines of tests that failed (where they passed in a second run, their stage passed):%s\n' "$details"
printf '\n'
printf '%s\n' "${results[@]}"
passed=$((${#results[@]} - failed))
printf '%s passed, %s failed\n' "$passed" "$failed"
exit $((failed > 0))
