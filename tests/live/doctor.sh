#!/usr/bin/env bash
# tools/doctor.sh finds the faults of a network namespace that is set up badly, fixes them, and then finds none.
bin=$1
. "$(dirname "$0")/namespace.sh"
export DOCTOR_ROOT="$work/system"
timer="$DOCTOR_ROOT/sys/bus/usb-serial/devices/ttyUSB0/latency_timer"
mkdir -p "${timer%/*}" "$DOCTOR_ROOT/dev"
echo 16 >"$timer"
touch "$DOCTOR_ROOT/dev/video0"
ip route del 224.0.0.0/4 dev lo
# The kernel lets a namespace have a time of its own for fragments.
echo 30 >/proc/sys/net/ipv4/ipfrag_time 2>/dev/null
doctor() { prlimit --rtprio=0 --memlock=8388608 -- setpriv --bounding-set=-sys_nice,-ipc_lock --inh-caps=-sys_nice,-ipc_lock -- "$root/tools/doctor.sh" --seconds 0 "$@" >"$work/out" 2>&1; }
expect() { grep -qE -- "$1" "$work/out" || failed "not '$1': $(cat "$work/out")"; }

doctor
code=$?
[ $code -eq 1 ] || failed "exit code $code, expected 1: $(cat "$work/out")"
expect '^FINDING  no route for multicast'
expect '^         fix:   ip link set lo up && ip route add 224.0.0.0/4 dev lo$'
expect '^FINDING  incomplete packets are kept for 30 s'
expect '^FINDING  no right to a real-time priority \(limit 0'
expect '^FINDING  only 8192 KiB of memory can be locked'
expect '^FINDING  serial port ttyUSB0 holds its answers for 16 ms'
expect '^ok       camera '
[ "$(grep -c ^FINDING "$work/out")" -eq "$(grep -c '^         fix:' "$work/out")" ] || failed "a finding without a fix: $(cat "$work/out")"
[ "$(cat "$timer")" = 16 ] || failed "without --fix, something is changed"

doctor --fix
for applied in 'ip route add' 'sysctl -w net.ipv4.ipfrag_time=1' 'rtprio' "echo 1 >$timer"; do expect "^         fixed: .*$applied"; done
grep -q 'rtprio 50' "$DOCTOR_ROOT/etc/security/limits.d/multireach.conf" || failed "no limits for the next login"
grep -qx 'net.ipv4.ipfrag_time=1' "$DOCTOR_ROOT/etc/sysctl.d/90-multireach-ipfrag_time.conf" || failed "nothing for the next start"
"$bin/multireach-controller" --config "$root/robots/hoap2/robot.yaml" --seconds 0.1 2>"$work/err" || failed "LCM does not start: $(cat "$work/err")"

# With the rights, nothing is left.
"$root/tools/doctor.sh" --seconds 0 >"$work/out" 2>&1
left=$(grep ^FINDING "$work/out" | grep -vE 'real-time priority|can be locked|receive buffers|the clock')
[ -z "$left" ] || failed "after the fixes: $left"

# A program that does not read loses packets, and that is found.
"$bin/multireach-vision" --config "$root/robots/hoap2/vision.yaml" 2>/dev/null & vision=$!
until grep -q ':1DF4 ' /proc/net/udp || ! kill -0 $vision 2>/dev/null; do sleep 0.05; done  # its socket for images, port 7668
kill -STOP $vision
# Images come for as long as the doctor looks, whenever it begins on a busy machine.
(while [ ! -e "$work/looked" ]; do lcm-logplayer --lcm-url='udpm://239.255.76.68:7668?ttl=0' --speed=0 "$root/logs/reach.lcm" >/dev/null; done) & player=$!
"$root/tools/doctor.sh" --seconds 3 >"$work/out" 2>&1
touch "$work/looked"
expect '^FINDING  [0-9]+ packets lost because a program did not read them in time, in 3 s$'
kill -CONT $vision; kill $vision $player 2>/dev/null; wait
"$root/tools/doctor.sh" --seconds 2>"$work/out" && failed "--seconds without a number"
expect '^doctor.sh: --seconds needs a whole number$'
finish
