#!/usr/bin/env bash
# lcm-spy with multireach's types: one window for the control group and one for the images. A double click on a channel shows
# its fields.
set -uo pipefail
scripts=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
# shellcheck source=tools/location.sh
. "$scripts/location.sh"
# shellcheck source=tools/groups.sh
. "$scripts/groups.sh"
if [ "${1:-}" = --help ]; then
  echo "Usage: $me [arguments of lcm-spy]"
  sed -n '2,3p' "$0" | cut -c3-
  echo "  --help   print this help and end"
  exit 0
fi
if ! [ -r "$types_jar" ] || ! command -v lcm-spy >/dev/null || ! command -v java >/dev/null; then
  [ "$installed" = no ] || { echo "$me: lcm-spy or Java is missing:  apt install liblcm-java libjchart2d-java default-jre" >&2; exit 1; }
  "$scripts/setup.sh" spy || exit 1
fi
# lcm-spy looks for types in CLASSPATH; its wrapper passes an option that Java 17 no longer knows.
export CLASSPATH="$types_jar" JDK_JAVA_OPTIONS=-XX:+IgnoreUnrecognizedVMOptions
trap 'kill "${spies[@]}" 2>/dev/null' EXIT
spies=()
groups_of "" || { echo "$me: $groups_error" >&2; exit 2; }
for url in "$control" "$images"; do
  LCM_DEFAULT_URL=$url lcm-spy "$@" & spies+=($!)
done
wait
