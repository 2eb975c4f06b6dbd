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
control=${LCM_DEFAULT_URL:-udpm://239.255.76.67:7667?ttl=0}
images=udpm://239.255.76.68:7668?ttl=0
if [[ $control != "udpm://239.255.76.67:7667?ttl=0" && $control =~ ^(udpm://[0-9.]+):([0-9]+)(.*)$ ]]; then
  images=${BASH_REMATCH[1]}:$((BASH_REMATCH[2] + 1))${BASH_REMATCH[3]}
fi
for url in "$control" "$images"; do
  LCM_DEFAULT_URL=$url lcm-spy "$@" & spies+=($!)
done
wait
