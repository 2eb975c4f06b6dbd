# shellcheck shell=bash disable=SC2034,SC2154  # variables are shared with the test that sources this
# Sourced after launched.sh by tests of the page.

# start NAME OPTION...: a run with a page; $address is the page's.
start() {
  launch "$1" --isolated --view "${@:2}" >"$work/$1.out"
  until address=$(grep -o 'http://[^ ]*' "$work/$1.out") || ! kill -0 $launched 2>/dev/null; do sleep 0.05; done
}
# Also in this test's own namespace, a run makes another one.
unset MULTIREACH_ISOLATED
