#!/usr/bin/env bash
# Builds the page into build/web with npm, where its sources have changed since. Only this needs the network, for packages.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root/web"
target=../build/web/index.html
sources=(index.html package.json package-lock.json vite.config.js tsconfig.json src)
definitions=(../lcmtypes/{bridge_state,controller_state,target,target_choice}_t.lcm)
if [ -e $target ] && [ -z "$(find "${sources[@]}" "${definitions[@]}" -newer $target -print -quit)" ]; then exit 0; fi
log=$(mktemp)
trap 'rm -f "$log"' EXIT
echo "Building the page" >&2
if [ ! -e node_modules/.package-lock.json ] || [ package-lock.json -nt node_modules/.package-lock.json ]; then
  # Not `npm ci`: that refuses a lock file without the binaries of every platform, which a mirror may not have.
  npm install --no-save --no-audit --no-fund >"$log" 2>&1 || { cat "$log" >&2; echo "web/build.sh: npm could not install the packages of package-lock.json" >&2; exit 1; }
fi
npm run build >"$log" 2>&1 || { cat "$log" >&2; echo "web/build.sh: the page could not be built" >&2; exit 1; }
touch $target
