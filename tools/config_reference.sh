#!/usr/bin/env bash
# Writes docs/configuration.md, the reference of all configuration keys, as the programs print it.
#   tools/config_reference.sh [FOLDER]     of the programs; default build/release/bin
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
bin=${1:-$root/build/release/bin}
{
  cat <<'END'
# Configuration

All keys of all configuration files. Each program prints the part that it reads with `--config-reference`; `tools/config_reference.sh`
writes this page from that. An unknown key, a value out of range and a missing file are errors that name file, line and key.

END
  for program in controller bridge robot-sim robot-driver vision camera key; do
    "$bin/multireach-$program" --config-reference
    echo
  done | awk '/^## /{ first = !seen[$0]++ } first' | cat -s | sed '$ { /^$/ d }'
} >"$root/docs/configuration.md"
