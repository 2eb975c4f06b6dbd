#!/usr/bin/env bash
# Builds the documentation as a static site, build/docs/index.html: all pages, and by Doxygen the API pages of the stages' public headers. A
# broken link and a warning of Doxygen are errors. Installs Doxygen and cmark-gfm where they are missing.
#   tools/docs.sh [--pages]     --pages: without the API pages, in a second
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
api=yes
case "${1:-}" in
  "") ;;
  --pages) api=no ;;
  --help|-h) sed -n '2,4p' "$0" | cut -c3-; exit 0 ;;
  *) echo "docs.sh: unknown option '$1'; see --help" >&2; exit 2 ;;
esac
tools/setup.sh docs
rm -rf build/docs
mkdir -p build/docs
if [ $api = yes ]; then
  # The headers that multireach_stage (cmake/options.cmake) installs; texts that other headers include are read through these.
  mapfile -t headers < <(find numeric kinematics imaging vision controller robot_bridge \
    \( -name node -o -name sim -o -name drivers \) -prune -o -name '*.hpp' ! -name '*.inl.hpp' ! -name '*-inl.hpp' -print | LC_ALL=C sort)
  { cat docs/Doxyfile; echo "INPUT = ${headers[*]}"; } | doxygen -
fi
/usr/bin/python3 tools/doc_site.py build/docs
