#!/usr/bin/env bash
# Installs the package into an empty folder, builds the example against it as a project of its own, and runs it.
#   tests/package/run.sh BUILD_FOLDER
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --install "$1" --prefix "$work/installed" >"$work/log"
cmake -S "$here" -B "$work/build" -G Ninja -DCMAKE_PREFIX_PATH="$work/installed" >>"$work/log"
cmake --build "$work/build" >>"$work/log" || { cat "$work/log" >&2; exit 1; }
"$work/build/reach" "$here/../../robots/hoap2/hoap2.urdf" torso right_hand >"$work/out"
# The hand must be within 0.1 mm of where it was sent.
tail -n 1 "$work/out" | awk '{ e = sqrt(($3 - 0.1)^2 + ($4 + 0.12)^2 + ($5 - 0.1)^2); print $0, "error", e; exit !(e < 1e-4) }'
