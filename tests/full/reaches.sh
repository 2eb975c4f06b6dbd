#!/usr/bin/env bash
# The studies of docs/guarantees.md, as rows of its table; fails when a reach does not arrive, exceeds a limit, or is not finite.
#   tests/full/reaches.sh BIN_FOLDER [SAMPLES [SAMPLES_OF_OTHER_ARMS]]     default 2000000 and 100000
set -euo pipefail
bin=$(cd "$1" && pwd)
samples=${2:-2000000} others=${3:-100000}
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
failed=0
echo "| arm | γ, rad²/m² | reaches | not arrived | beyond a position limit | a speed limit | not finite | path p50 | p95 | settled, s: p50 | p95 |"
echo "|---|---|---|---|---|---|---|---|---|---|---|"
# study NAME URDF BASE TIP SAMPLES [OPTIONS...]
study() {
  local name=$1 urdf=$2 base=$3 tip=$4 number=$5; shift 5
  if [ ! -e "$urdf" ]; then echo "skipped: $name ($urdf is not here)" >&2; return; fi
  "$bin/multireach-study" --urdf "$urdf" --base "$base" --tip "$tip" --samples "$number" "$@" --csv - --json /dev/null |
    awk -F, -v name="$name" 'NR > 1 { printf "| %s | %.0f | %d | %d | %d | %d | %d | %.3f | %.2f | %.2f | %.2f |\n", name, $1, $2, $3, $5, $6, $7, $9, $10, $11, $12
                              bad += $3 + $5 + $6 + $7 } END { exit bad > 0 }' || failed=1
}
gammas=100,350,1000,10000
study "Hoap2" "$root/robots/hoap2/hoap2.urdf" torso right_hand "$samples" --gamma $gammas
study "Hoap2, default γ" "$root/robots/hoap2/hoap2.urdf" torso right_hand "$samples"
robots="$root/../shared/robots"
study "Panda" "$robots/panda.urdf" panda_link0 panda_hand "$others" --gamma $gammas
study "UR5" "$robots/ur5_robot.urdf" base_link ee_link "$others" --gamma $gammas
study "Kinova j2s6s200" "$robots/kinova.urdf" j2s6s200_link_base j2s6s200_end_effector "$others" --gamma $gammas
study "Baxter, left" "$robots/baxter.urdf" base left_gripper "$others" --gamma $gammas
study "iiwa 14" "$robots/iiwa14.urdf" base iiwa_link_ee "$others" --gamma $gammas
exit $failed
