#!/usr/bin/env bash
# "An arm in ten minutes" (docs/your-robot.md), done literally with an arm that the project does not have: the robot.yaml printed there, with
# the names of the Kinova Jaco of ../shared/robots, and the example of cameras of the UR5e. Every position is reached.
bin=$1
timed=yes
. "$(dirname "$0")/namespace.sh"
. "$root/tests/live/launched.sh"
urdf=$root/../shared/robots/kinova.urdf
[ -r "$urdf" ] || { echo "skipped: the arms of shared/robots are not here"; exit 77; }
arm=$work/kinova
cp -r "$root/robots/ur5e" "$arm"
rm "$arm/ur5e.urdf" "$arm/README.md"
cp "$urdf" "$arm"
awk '/^```/ { inside = /yaml/; next } inside' "$root/docs/your-robot.md" >"$work/printed.yaml"
grep -q 'tip: TIP' "$work/printed.yaml" || wrong "docs/your-robot.md prints no robot.yaml: $(cat "$work/printed.yaml")"
sed 's/FILE/kinova/; s/: BASE/: j2s6s200_link_base/; s/: TIP/: j2s6s200_end_effector/' "$work/printed.yaml" >"$arm/robot.yaml"
launch kinova --robot "$arm"
ended 0
[ "$(reached)" -eq 5 ] || failed "$(reached) of 5 positions reached"

# What a user sees who leaves the start configuration of the arm that was copied.
grep -A3 '^start_joint_position' "$root/robots/ur5e/robot.yaml" >>"$arm/robot.yaml"
launch wrong --robot "$arm"
ended 2
says "key 'start_joint_position' expected positions of joints of "
says "which has no joint 'elbow_joint'; it has j2s6s200_joint_1, "
finish
