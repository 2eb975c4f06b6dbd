#!/usr/bin/env bash
# lcm-spy with multireach's types: one window for the control group and one for the images. A double click on a channel shows
# its fields.
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
types="$root/build/release/multireach-types.jar"
{ [ -r "$types" ] && command -v lcm-spy java >/dev/null; } || "$root/tools/setup.sh" spy || exit 1
# lcm-spy looks for types in CLASSPATH; its wrapper passes an option that Java 17 no longer knows.
export CLASSPATH="$types" JDK_JAVA_OPTIONS=-XX:+IgnoreUnrecognizedVMOptions
trap 'kill "${spies[@]}" 2>/dev/null' EXIT
spies=()
for group in 239.255.76.67:7667 239.255.76.68:7668; do
  LCM_DEFAULT_URL="udpm://$group?ttl=0" lcm-spy "$@" & spies+=($!)
done
wait
