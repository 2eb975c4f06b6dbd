# Sourced by tests that send no messages: $bin, $root, the folder $work that goes away, fail SENTENCE, and what refuses.sh has.
# They end with `exit $failed`.
set -uo pipefail
bin=$1
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
fail() { echo "FAILED: $*"; failed=1; }
. "$root/tests/live/refuses.sh"
