#!/usr/bin/env bash
# Writes the pages of docs/ that are made from the programs and the messages: configuration.md, programs/, messages.md.
#   tools/reference_pages.sh [FOLDER]          of the programs; default build/release/bin
#   tools/reference_pages.sh --list [FOLDER]   only prints which programs and scripts have pages
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
list=no
case "${1:-}" in
  --help|-h) sed -n '2,4p' "$0" | cut -c3-; exit 0 ;;
  --list) list=yes; shift ;;
  -*) echo "reference_pages.sh: unknown option '$1'; see --help" >&2; exit 2 ;;
esac
bin=${1:-$root/build/release/bin}
commands=()
for program in "$bin"/multireach-*; do
  [[ ${program##*/} =~ ^multireach-(test|fuzz|bench)- ]] || [ ! -x "$program" ] || commands+=("$program")
done
for script in launch doctor spy; do commands+=("$root/tools/$script.sh=multireach-$script"); done
if [ $list = yes ]; then printf '%s\n' "${commands[@]}"; exit 0; fi

rm -rf "$root/docs/programs"
/usr/bin/python3 "$root/tools/program_pages.py" --markdown "$root/docs/programs" "${commands[@]}"
/usr/bin/python3 "$root/tools/message_page.py" >"$root/docs/messages.md.new"
mv "$root/docs/messages.md.new" "$root/docs/messages.md"
{
  cat <<'END'
# Configuration

All keys of all configuration files. Each program prints the part that it reads with `--config-reference`; `tools/reference_pages.sh`
writes this page from that. An unknown key, a value out of range and a missing file are errors that name file, line and key.

END
  for program in controller bridge robot-sim robot-driver vision camera key; do
    "$bin/multireach-$program" --config-reference
    echo
  done | awk '/^## /{ first = !seen[$0]++ } first' | cat -s | sed '$ { /^$/ d }'
} >"$root/docs/configuration.md"
