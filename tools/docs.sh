#!/usr/bin/env bash
# Makes the API pages of the stages' public headers by Doxygen, in build/docs/html. Fails on any warning. Installs Doxygen where it is missing.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
case "${1:-}" in
  "") ;;
  --help|-h) sed -n '2p' "$0" | cut -c3-; exit 0 ;;
  *) echo "docs.sh: unknown option '$1'; see --help" >&2; exit 2 ;;
esac
tools/setup.sh docs
# The headers that multireach_stage (cmake/options.cmake) installs; texts that other headers include are read through these.
mapfile -t headers < <(find numeric kinematics imaging vision controller robot_bridge \
  \( -name node -o -name sim -o -name drivers \) -prune -o -name '*.hpp' ! -name '*.inl.hpp' ! -name '*-inl.hpp' -print | LC_ALL=C sort)
mkdir -p build
rm -rf build/docs
{ cat docs/Doxyfile; echo "INPUT = ${headers[*]}"; } | doxygen -
echo "${#headers[@]} headers: build/docs/html/index.html"
