# shellcheck shell=bash disable=SC2034,SC2154  # variables are shared with the script that sources this
# Sourced by scripts: the UDP groups of one instance of the pipeline.

# groups_of [N [TTL]]: sets `control` and `images`, the URLs of the two groups. Without N: LCM_DEFAULT_URL, else the default groups.
# Each N has ports of its own, too: a socket receives what is sent to its port on any group that a process of its host has joined.
# Returns 1, with a sentence in `groups_error`, when LCM_DEFAULT_URL is no UDP group.
groups_of() {
  local n=${1:-} ttl=${2:-0}
  control=${LCM_DEFAULT_URL:-udpm://239.255.76.67:7667?ttl=$ttl}
  [ -z "$n" ] || control="udpm://239.255.77.$n:$((8000 + 2 * n))?ttl=$ttl"
  images='udpm://239.255.76.68:7668?ttl=0' groups_error=""
  [ "$control" != 'udpm://239.255.76.67:7667?ttl=0' ] || return 0
  # As the programs have it: the same group, one port above.
  if [[ ! $control =~ ^udpm://([0-9.]+):([0-9]+)(\?.*)?$ ]]; then
    groups_error="LCM_DEFAULT_URL: '$control' is not udpm://ADDRESS:PORT?ttl=N"
    return 1
  fi
  images="udpm://${BASH_REMATCH[1]}:$((BASH_REMATCH[2] + 1))${BASH_REMATCH[3]}"
}
