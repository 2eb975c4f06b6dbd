#!/usr/bin/env bash
# lcm-spy with multireach's types: one window for the control group and one for the images. A double click on a channel shows
# its fields.
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
. "$root/tools/groups.sh"
types="$root/build/release/multireach-types.jar"
{ [ -r "$types" ] && command -v lcm-spy java >/dev/null; } || "$root/tools/setup.sh" spy || exit 1
# lcm-spy looks for types in CLASSPATH; its wrapper passes an option that Java 17 no longer knows.
export CLASSPATH="$types" JDK_JAVA_OPTIONS=-XX:+IgnoreUnrecognizedVMOptions
trap 'kill "${spies[@]}" 2>/dev/null' EXIT
spies=()
groups_of "" || { echo "spy.sh: $groups_error" >&2; exit 2; }
for url in "$control" "$images"; do
  LCM_DEFAULT_URL=$url lcm-spy "$@" & spies+=($!)
done
wait
