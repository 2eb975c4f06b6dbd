#!/usr/bin/env bash
# The systemd units are valid, name programs and options that exist, and leave the bridge its real-time priority.
bin=$1
. "$(dirname "$0")/namespace.sh"
command -v systemd-analyze >/dev/null || { echo "skipped: systemd-analyze is not here (Debian package systemd)"; exit 77; }
tree="$work/root"
install_units() { DESTDIR=$tree cmake -DCMAKE_INSTALL_PREFIX="$1" -P "$root/tools/systemd/install.cmake" >/dev/null 2>&1; }
install_units /usr/local || failed "install.cmake: exit code $?"
mkdir -p "$tree"/usr/{local/bin,bin,lib/systemd/system}
nodes=(vision controller bridge robot-driver robot-sim camera)
for node in "${nodes[@]}"; do cp "$bin/multireach-$node" "$tree/usr/local/bin"; done
cp "$(command -v lcm-logger)" "$tree/usr/bin"
for kind in target slice mount; do cp /lib/systemd/system/*."$kind" "$tree/usr/lib/systemd/system"; done
verify() { systemd-analyze verify --root="$tree" multireach.target "${nodes[@]/#/multireach@}" multireach-record@{control,images}.service 2>&1; }
nodes=("${nodes[@]/%/.service}")
said=$(verify) || failed "systemd-analyze fails: $said"
[ -z "$said" ] || failed "systemd-analyze says: $said"
conf="$tree/usr/local/lib/systemd/system/multireach@bridge.service.d/real-time.conf"
cp "$conf" "$work/sound"
sed -i 's/^LimitRTPRIO/LimitRTPRI/' "$conf"
verify | grep -q "Unknown key 'LimitRTPRI'" || failed "systemd-analyze does not see a wrong key"
cp "$work/sound" "$conf"

# The driver has the serial ports and the bridge has not; recorders are guarded, by the library that is installed there, and are restarted
# without end.
units="$tree/usr/local/lib/systemd/system"
for line in 'SupplementaryGroups=dialout' 'DeviceAllow=char-ttyUSB rw' 'DeviceAllow=char-ttyACM rw' 'CPUSchedulingPolicy=fifo'; do
  grep -qx "$line" "$units/multireach@robot-driver.service.d/real-time.conf" || failed "the driver's unit lacks $line"
done
grep -q dialout "$conf" && failed "the bridge has the serial ports, which it does not need"
for line in Restart=always StartLimitIntervalSec=0 Environment=LD_PRELOAD=/usr/local/lib/multireach/libmultireach-datagram-guard.so; do
  grep -qx "$line" "$units/multireach-record@.service" || failed "the recorder's unit lacks $line"
done
[ -r "$bin/libmultireach-datagram-guard.so" ] || failed "the guard is not built under the name that the unit has"
grep -q 'multireach-datagram-guard LIBRARY DESTINATION ${script_dir}' "$root/cmake/install.cmake" || failed "the guard is installed elsewhere"

# The units of the Debian package name its programs and options, and nothing of /usr/local.
install_units /usr || failed "install.cmake for /usr: exit code $?"
grep -qx 'ExecStart=/usr/bin/multireach-%i $OPTIONS' "$tree/usr/lib/systemd/system/multireach@.service" || failed "the package's unit starts something else"
grep -rq /usr/local "$tree"/usr/lib/systemd/system/multireach* && failed "the package's units name /usr/local"
for node in multireach vision controller bridge robot-driver robot-sim camera record-control record-images; do
  [ -r "$tree/usr/share/multireach/systemd/$node.env" ] || failed "no default options for $node"
done
[ -e "$tree/etc/multireach" ] && failed "files in /etc/multireach, which is the user's"

# Without capabilities, with the unit's limits only, the bridge has its priority; without the limits it warns.
limit() { sed -n "s/^$1=//p" "$conf" | sed 's/infinity/unlimited/'; }
chmod 755 "$work"
as_the_unit() {
  timeout -s INT 4 prlimit --rtprio="$1" --memlock="$2" -- setpriv --reuid 65534 --regid 65534 --clear-groups --bounding-set=-all --no-new-privs -- \
    "$bin/multireach-bridge" --config "$root/robots/hoap2/robot.yaml" --seconds 1 2>&1
}
said=$(as_the_unit 0 8388608)
if [ "$(id -u)" -eq 0 ] && prlimit --rtprio=50 true 2>/dev/null && grep -q "is running" <<<"$said"; then
  grep -q "no real-time priority" <<<"$said" || failed "the bridge does not say that it has no priority"
  said=$(as_the_unit "$(limit LimitRTPRIO)" "$(limit LimitMEMLOCK)")
  grep -q 'is running' <<<"$said" || failed "the bridge does not run: $said"
  grep -qE 'no (real-time|locked)' <<<"$said" && failed "with the unit's limits: $said"
else
  echo "not checked: the limits of the bridge's unit cannot be set here"
fi
[ -z "${MULTIREACH_KEEP:-}" ] || echo "$said"
grep -rq '^RestrictRealtime' "$tree/usr/local/lib/systemd/system" && failed "RestrictRealtime forbids SCHED_FIFO"
finish
