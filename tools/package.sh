#!/usr/bin/env bash
# Builds the Debian packages, in build/packages: multireach, multireach-camera, libmultireach-dev, python3-multireach. Installs
# what the build needs.
#   tools/package.sh
# It takes some ten minutes on two cores; only the page's packages come from outside of Debian (npm).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
case "${1:-}" in
  "") ;;
  --help|-h) sed -n '2,5p' "$0" | cut -c3-; exit 0 ;;
  *) echo "package.sh: unknown option '$1'; see --help" >&2; exit 2 ;;
esac
cd "$root"
tools/setup.sh package
rm -rf build/packages
mkdir -p build/packages
cpack --config build/release/CPackConfig.cmake -B build/packages >build/packages/log 2>&1 || { cat build/packages/log >&2; exit 1; }
rm -rf build/packages/_CPack_Packages
ls -1 build/packages/*.deb
