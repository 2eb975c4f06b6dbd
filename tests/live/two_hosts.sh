#!/usr/bin/env bash
# Two computers on a switch, as network namespaces: cameras and controller on one, bridge and robot on the other. All positions are
# reached; when the cable of the first is pulled for two seconds, the arm stops on a ramp and continues by itself.
bin=$1
timed=yes
. "$(dirname "$0")/namespace.sh"
. "$root/tests/live/launched.sh"
. "$root/tests/live/hosts.sh"
if ! ip link add dev switch type bridge mcast_snooping 0 2>/dev/null; then echo "skipped: a network bridge cannot be made here"; exit 77; fi
ip link set switch up
host eyes 10.0.0.1 0
host robot 10.0.0.2 86400
ip link set to_eyes master switch
ip link set to_robot master switch

both
both_ended
[ $eyes_code -eq 0 ] || failed "eyes: exit code $eyes_code: $(cat "$work/eyes.err")"
[ $robot_code -eq 0 ] || failed "robot: exit code $robot_code: $(cat "$work/robot.err")"
for name in eyes robot; do [ "$(reached)" -ge 6 ] || failed "$name: $(reached) positions reached"; done
name=robot; [ "$(report images)" = 0 ] || failed "$(report images) pairs of images were sent to the robot's computer"

both --seconds 10
interrupted
[ -z "${MULTIREACH_KEEP:-}" ] || cat "$work"/{eyes,robot}.{out,err}
finish
