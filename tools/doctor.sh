#!/usr/bin/env bash
# Checks whether this computer is set up for multireach, and prints how to fix what is not.
#   --fix        fix what can be fixed, as root; settings are also written for the next start of the computer
#   --seconds N  how long to look for lost packets (default: 2), best while the processes run
#   --help       print this help and end
# Checked: route for multicast, receive buffers, fragments, real-time rights, clock, cameras, serial ports, lost packets, clocks of other computers.
# Exit code: 0 all is well, 1 there are findings, 2 wrong usage.
set -uo pipefail
fix=no seconds=2
while [ $# -gt 0 ]; do
  case "$1" in
    --fix) fix=yes; shift ;;
    --seconds)
      [[ $# -ge 2 && $2 =~ ^[0-9]+$ ]] || { echo "${0##*/}: --seconds needs a whole number" >&2; exit 2; }
      seconds=$2; shift 2 ;;
    --help|-h) echo "Usage: ${0##*/} [--fix] [--seconds N]"; sed -n '2,7p' "$0" | cut -c3-; exit 0 ;;
    *) echo "${0##*/}: unknown option '$1'; see --help" >&2; exit 2 ;;
  esac
done
system=${DOCTOR_ROOT:-}  # for tests: where /sys, /dev and /etc are
findings=0 record=
scripts=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
# shellcheck source=tools/location.sh
. "$scripts/location.sh"

well() { printf 'ok       %s\n' "$1"; }
note() { printf 'note     %s\n' "$1"; }
# finding SENTENCE FIX [CHECK]: FIX is a shell command, which --fix runs. CHECK then tells whether it has helped; without CHECK, it takes effect later.
finding() {
  printf 'FINDING  %s\n' "$1"
  if [ $fix = yes ] && bash -c "$2" >/dev/null 2>&1; then
    if [ -z "${3:-}" ] || $3; then printf '         fixed: %s\n' "$2"; return; fi
  fi
  findings=$((findings + 1))
  printf '         fix:   %s\n' "$2"
}
# advice SENTENCE FIX: a fix that is no shell command, which --fix cannot apply.
advice() {
  findings=$((findings + 1))
  printf 'FINDING  %s\n         fix:   %s\n' "$1" "$2"
}
# has_capability BIT
has_capability() { [ $(((0x$(sed -n 's/^CapEff:\t//p' /proc/self/status) >> $1) & 1)) -eq 1 ]; }
setting() { cat "/proc/sys/${1//.//}" 2>/dev/null || echo 0; }
# keep_setting NAME VALUE: the command that sets it, now and at the next start.
keep_setting() { echo "sysctl -w $1=$2 && mkdir -p $system/etc/sysctl.d && echo $1=$2 >$system/etc/sysctl.d/90-multireach-${1##*.}.conf"; }

multicast_device() { ip route get 239.255.76.67 2>/dev/null | sed -n 's/.* dev \([^ ]*\).*/\1/p' | grep .; }
check_route() {
  local device
  if device=$(multicast_device); then
    well "multicast uses $device$([ "$device" != lo ] || echo ' and stays on this computer')"
  else
    finding "no route for multicast: LCM cannot start" 'ip link set lo up && ip route add 224.0.0.0/4 dev lo' multicast_device
    echo "         between two computers, instead of lo the interface between them, as  ip route add 224.0.0.0/4 dev eth0"
  fi
}

enough_buffer() { [ "$(setting net.core.rmem_max)" -ge 4194304 ]; }
check_buffers() {
  if enough_buffer; then well "receive buffers of up to $(setting net.core.rmem_max) bytes"; return; fi
  finding "receive buffers of at most $(setting net.core.rmem_max) bytes: most raw images are lost; 4194304 are asked for" \
    "$(keep_setting net.core.rmem_max 4194304)" enough_buffer
}

short_fragments() { [ "$(setting net.ipv4.ipfrag_time)" -le 1 ]; }
check_fragments() {
  if short_fragments; then well "incomplete packets are dropped after $(setting net.ipv4.ipfrag_time) s"; return; fi
  finding "incomplete packets are kept for $(setting net.ipv4.ipfrag_time) s: between two computers, one lost fragment in twenty stops all images" \
    "$(keep_setting net.ipv4.ipfrag_time 1)" short_fragments
}

check_rights() {
  local user=${SUDO_USER:-$(id -un)} file=$system/etc/security/limits.d/multireach.conf rtprio memlock
  rtprio=$(ulimit -Hr) memlock=$(ulimit -Hl)
  local write="mkdir -p ${file%/*} && printf '%s - rtprio 50\n%s - memlock unlimited\n' $user $user >$file"
  if has_capability 23 || [ "$rtprio" = unlimited ] || [ "$rtprio" -ge 40 ]; then
    well "the bridge may have a real-time priority"
  else
    finding "no right to a real-time priority (limit $rtprio, 40 is asked for): periods are missed while the computer is busy" "$write"
    echo "         from the next login of $user on; systemd units have limits of their own"
  fi
  if has_capability 14 || [ "$memlock" = unlimited ]; then
    well "the bridge may lock its memory"
  else
    finding "only $memlock KiB of memory can be locked: a page that is swapped out makes the bridge miss periods" "$write"
  fi
  if [ "$(cat /sys/kernel/realtime 2>/dev/null)" = 1 ]; then well "a real-time kernel"; else note "not a real-time kernel (Debian: linux-image-rt-amd64); expect late periods now and then"; fi
}

check_clock() {
  case "$(timedatectl show --property NTPSynchronized --value 2>/dev/null)" in
    yes) well "the clock is synchronised" ;;
    no) finding "the clock is not synchronised: logs of two computers cannot be compared" 'apt-get install -y systemd-timesyncd && timedatectl set-ntp true' ;;
    *)
      if chronyc tracking 2>/dev/null | grep -q 'Leap status *: Normal'; then well "the clock is synchronised (chrony)"
      else note "whether the clock is synchronised cannot be told here (timedatectl, chronyc)"; fi ;;
  esac
}

# record_status: nodes announce themselves once a second; the record has the times by this computer's clock.
record_status() {
  [ "$seconds" -ge 2 ] && [ -x "$bin/multireach-log" ] && command -v lcm-logger >/dev/null && multicast_device >/dev/null || return
  record=$(mktemp -d)
  timeout -s INT "$seconds" env LD_PRELOAD="$guard" lcm-logger --channel NODE_STATUS --quiet "$record/status.lcm" >/dev/null 2>&1 &
  recorder=$!
}
check_other_clocks() {
  local line any=no
  [ -n "$record" ] || return
  wait "$recorder"
  while read -r line; do
    any=yes
    advice "$line: logs of both cannot be merged, and a real robot refuses commands that are 1 s off (Franka: 50 ms)" 'synchronise both clocks, as by chrony or systemd-timesyncd'
  done < <("$bin/multireach-log" report "$record/status.lcm" --robot "$root/robots/hoap2" 2>&1 | sed -n "s/^\(clock of .*\) the recorder's$/\1 this computer's/p")
  if [ $any = no ] && [ -s "$record/status.lcm" ]; then well "the clocks of all running nodes agree with this computer's"; fi
  rm -r "$record"
}

check_cameras() {
  local device any=no
  for device in "$system"/dev/video*; do
    [ -e "$device" ] || continue
    any=yes
    if [ -r "$device" ] && [ -w "$device" ]; then well "camera $device, $(cat "$system/sys/class/video4linux/${device##*/}/name" 2>/dev/null || echo 'name unknown')"
    else finding "camera $device may not be opened by $(id -un)" "usermod -aG video $(id -un)"; fi
  done
  [ $any = yes ] || note "no camera is plugged in"
}

low_latency() { ! grep -qvx 1 "$system"/sys/bus/usb-serial/devices/*/latency_timer; }
check_serial() {
  local timer port rule="$system/etc/udev/rules.d/90-multireach-latency.rules"
  for timer in "$system"/sys/bus/usb-serial/devices/*/latency_timer; do
    [ -e "$timer" ] || continue
    port=${timer%/*} port=${port##*/}
    if [ "$(cat "$timer")" -le 1 ]; then well "serial port $port answers without delay"; continue; fi
    finding "serial port $port holds its answers for $(cat "$timer") ms" \
      "echo 1 >$timer && mkdir -p ${rule%/*} && echo 'ACTION==\"add\", SUBSYSTEM==\"usb-serial\", DRIVER==\"ftdi_sio\", ATTR{latency_timer}=\"1\"' >$rule" low_latency
  done
}

# Sets lost[NAME] for each counter of lost packets.
declare -A lost
count_lost() {
  local protocol values key k
  while read -r -a key && read -r -a values; do
    protocol=${key[0]%:}
    for k in "${!key[@]}"; do
      case "$protocol.${key[$k]}" in Udp.RcvbufErrors|Ip.ReasmFails) lost[${key[$k]}]=${values[$k]} ;; esac
    done
  done </proc/net/snmp
}
check_lost() {
  local -A before
  local name
  count_lost
  for name in "${!lost[@]}"; do before[$name]=${lost[$name]}; done
  sleep "$seconds"
  count_lost
  for name in RcvbufErrors ReasmFails; do
    local more=$((${lost[$name]} - ${before[$name]})) what advised
    case $name in
      RcvbufErrors) what="packets lost because a program did not read them in time" advised="the computer is too busy, or a program does not read: stop other work, close idle LCM tools" ;;
      ReasmFails) what="packets lost because a fragment of them was lost on the network" advised="use a cable and a switch of their own; send JPEG instead of raw images" ;;
    esac
    if [ $more -gt 0 ]; then advice "$more $what, in $seconds s" "$advised"
    else well "no $what, in $seconds s$([ "${lost[$name]}" -eq 0 ] || echo " (since the start: ${lost[$name]})")"; fi
  done
}

check_route
check_buffers
check_fragments
check_rights
check_clock
check_cameras
check_serial
record_status
check_lost
check_other_clocks
exit $((findings > 0))
