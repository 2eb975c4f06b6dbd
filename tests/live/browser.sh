# shellcheck shell=bash disable=SC2154  # `bin` is the test's
# Sourced first by tests of the page: skips where there is no browser or no page, and builds the page.
skip() { echo "skipped: $1"; exit 77; }
chromium=$(command -v "${CHROMIUM:-chromium}") || skip "there is no Chromium (Debian's package chromium)"
export CHROMIUM=$chromium
[ -x "$bin/multireach-page" ] || skip "multireach-page is not built (tools/setup.sh page)"
command -v npm >/dev/null || skip "there is no npm"
# In the network namespace there are no packages to be had.
if [ -z "${MULTIREACH_ISOLATED:-}" ]; then
  timeout 120 "$(dirname "${BASH_SOURCE[0]}")/../../web/build.sh" || skip "the page cannot be built: npm has no packages"
fi
