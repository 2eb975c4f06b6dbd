#!/usr/bin/env bash
# Installs the package into an empty folder, builds the example against it as a project of its own, by CMake and by pkg-config, and
# runs it. The installation works in another folder, too.
#   tests/package/run.sh BUILD_FOLDER
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --install "$1" --prefix "$work/first" --component development >"$work/log"
mv "$work/first" "$work/installed"
# The hand must be within 0.1 mm of where it was sent.
check() {
  "$1" "$here/../../robots/hoap2/hoap2.urdf" torso right_hand >"$work/out"
  tail -n 1 "$work/out" | awk -v by="$2" '{ e = sqrt(($3 - 0.1)^2 + ($4 + 0.12)^2 + ($5 - 0.1)^2); print by ":", $0, "error", e; exit !(e < 1e-4) }'
}
cmake -S "$here" -B "$work/build" -G Ninja -DCMAKE_PREFIX_PATH="$work/installed" >>"$work/log"
cmake --build "$work/build" >>"$work/log" || { cat "$work/log" >&2; exit 1; }
check "$work/build/reach" "find_package"

PKG_CONFIG_PATH=$(dirname "$(find "$work/installed" -name multireach.pc)")
export PKG_CONFIG_PATH
for part in multireach multireach-vision; do
  # shellcheck disable=SC2046  # words
  "${CXX:-c++}" -o "$work/reach" "$here/reach.cpp" $(pkg-config --cflags --libs $part) -std=c++20
  check "$work/reach" "pkg-config $part"
done

# A component that does not exist is an error that names those that do.
sed 's/COMPONENTS controller/COMPONENTS nonsense/' "$here/CMakeLists.txt" >"$work/CMakeLists.txt"
cp "$here/reach.cpp" "$work"
if cmake -S "$work" -B "$work/wrong" -G Ninja -DCMAKE_PREFIX_PATH="$work/installed" >"$work/log" 2>&1; then
  echo "find_package finds the component 'nonsense'" >&2
  exit 1
fi
grep -q "has no component 'nonsense': expected numeric" "$work/log" || { cat "$work/log" >&2; exit 1; }
