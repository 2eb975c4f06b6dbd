#!/usr/bin/env bash
# Draws the pictures of docs/guarantees.md, from the project's own programs, with gnuplot.
#   tools/figures.sh [--into DIR] [NAME...]     limits arrival singularity targets posture-choice push obstacle orientation; default: all
# The last needs an arm of six joints or more: ../shared/robots/panda.urdf, or the one that MULTIREACH_ARM names (URDF:BASE:TIP).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
pictures=docs/pictures/guarantees
case "${1:-}" in
  --help|-h) sed -n '2,4p' "$0" | cut -c3-; exit 0 ;;
  --into) pictures=${2:?--into needs a folder}; shift 2 ;;
esac
{ command -v gnuplot && [ -x build/release/bin/multireach-figures ]; } >/dev/null || tools/setup.sh --tests
mkdir -p "$pictures"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
hoap2=(--urdf robots/hoap2/hoap2.urdf --base torso --tip right_hand)

# draw NAME SIZE: gnuplot commands on standard input; "$csv" in them is the scene's table.
draw() {
  { printf 'set terminal svg size %s font "sans,12" background "white"\nset output "%s/%s.svg"\n' "$2" "$pictures" "$1"
    printf 'set datafile separator ","\nset key autotitle columnhead noenhanced outside right top\nset grid lc "#dddddd"\nset xlabel "time (s)"\n'
    printf 'csv = "%s/%s.csv"\nset style data lines\nset linetype 1 lc "#1f6fb4" lw 2\nset linetype 2 lc "#d1495b" lw 2\n' "$work" "$1"
    printf 'set linetype 3 lc "#3a9d5d" lw 2\nset linetype 4 lc "#8a5fb0" lw 2\nset linetype 5 lc "#777777" lw 1 dt 2\n'
    cat; } | gnuplot
  echo "$pictures/$1.svg"
}
scene() { build/release/bin/multireach-figures "$1" "${@:2}" --csv "$work/$1.csv"; }

limits() {
  scene limits "${hoap2[@]}"
  draw limits 760,640 <<'GNUPLOT'
set multiplot layout 3,1
set xlabel ""
set ylabel "angle (rad)"
plot csv u 1:2 t "paper" lt 2, '' u 1:3 t "guarded" lt 1, '' u 1:4 t "limit" lt 5
set ylabel "speed (rad/s)"
plot csv u 1:6 t "paper" lt 2, '' u 1:7 t "guarded" lt 1, '' u 1:8 t "limit" lt 5, '' u 1:(-$8) t "" lt 5
set xlabel "time (s)"
set ylabel "acceleration (rad/s²)"
plot csv u 1:9 t "guarded" lt 1, '' u 1:10 t "limit" lt 5, '' u 1:(-$10) t "" lt 5
GNUPLOT
}
arrival() {
  scene arrival "${hoap2[@]}"
  draw arrival 760,480 <<'GNUPLOT'
set multiplot layout 2,1
set logscale y
set format y "10^{%L}"
set xlabel ""
set ylabel "hand to target (m)"
set yrange [1e-6:1]
plot csv u 1:2 t "paper" lt 2, '' u 1:3 t "guarded" lt 1, 1e-4 t "arrived: 0.1 mm" lt 5
set xlabel "time (s)"
set ylabel "γ (rad²/m²)"
set yrange [*:*]
plot csv u 1:4 t "guarded" lt 1
GNUPLOT
}
singularity() {
  scene singularity "${hoap2[@]}"
  draw singularity 760,640 <<'GNUPLOT'
set multiplot layout 3,1
set xlabel ""
set ylabel "hand to target (m)"
set logscale y
set format y "10^{%L}"
set yrange [1e-6:1]
plot csv u 1:3 t "guarded" lt 1, 1e-4 t "arrived: 0.1 mm" lt 5
unset logscale y
set format y "%g"
set yrange [0:7]
set ylabel "fastest joint (rad/s)"
plot csv u 1:5 t "guarded" lt 1, '' u 1:6 t "limit" lt 5
set xlabel "time (s)"
set ylabel "condition number"
set yrange [0:*]
plot csv u 1:7 t "guarded" lt 1, '' u 1:8 t "bound of Eq. (32)" lt 5
GNUPLOT
}
targets() {
  scene targets "${hoap2[@]}"
  draw targets 900,640 <<'GNUPLOT'
set multiplot layout 3,1
set xtics 2
set xlabel ""
set ylabel "y in W (m)"
set label "rests" at 1,graph 0.92 center
set label "moves" at 6,graph 0.92 center
set label "jumps" at 10,graph 0.92 center
set label "noisy" at 12.5,graph 0.92 center
set label "lost" at 15,graph 0.92 center
set label "returns" at 17,graph 0.92 center
set label "out of reach" at 19,graph 0.92 center
set label "returns" at 21,graph 0.92 center
set yrange [-0.23:-0.06]
plot csv u 1:3 t "target" lt 2, '' u 1:6 t "hand" lt 1
unset label
set ylabel "hand to target (m)"
set yrange [1e-5:1]
set logscale y
set format y "10^{%L}"
plot csv u 1:8 t "distance" lt 1
unset logscale y
set format y "%g"
set yrange [0:*]
set xlabel "time (s)"
set ylabel "fastest joint (rad/s)"
plot csv u 1:9 t "guarded" lt 1
GNUPLOT
}
posture-choice() {
  scene posture-choice "${hoap2[@]}"
  draw posture-choice 760,640 <<'GNUPLOT'
set multiplot layout 3,1
set xlabel ""
set ylabel "θ_T (rad)"
plot csv u 1:2 t "SFE" lt 1, '' u 1:3 t "SAA" lt 2, '' u 1:4 t "SHR" lt 3, '' u 1:5 t "EB" lt 4
set ylabel "θ (rad)"
plot csv u 1:6 t "SFE" lt 1, '' u 1:7 t "SAA" lt 2, '' u 1:8 t "SHR" lt 3, '' u 1:9 t "EB" lt 4
set xlabel "time (s)"
set ylabel "speed (rad/s), choices"
plot csv u 1:10 t "fastest joint" lt 1, '' u 1:12 t "θ_T chosen" lt 5
GNUPLOT
}
push() {
  scene push "${hoap2[@]}"
  draw push 760,480 <<'GNUPLOT'
set multiplot layout 2,1
set xlabel ""
set ylabel "SAA (rad)"
plot csv u 1:4 t "the arm" lt 5, '' u 1:2 t "command, open" lt 2, '' u 1:3 t "command, measured" lt 1
set xlabel "time (s)"
set ylabel "arm's hand to target (m)"
plot csv u 1:8 t "the arm" lt 1
GNUPLOT
}
obstacle() {
  scene obstacle "${hoap2[@]}"
  draw obstacle 760,640 <<'GNUPLOT'
set multiplot layout 2,1
set xlabel "y (m)"
set ylabel "z (m)"
set size ratio -1
stats csv u 12 name "Y" nooutput
stats csv u 13 name "Z" nooutput
set object 1 rectangle center Y_mean,Z_mean size 0.01,0.06 fc "#bbbbbb" fs solid
plot csv u 7:8 t "without the wall" lt 2, '' u 3:4 t "around it" lt 1
unset object 1
set size noratio
set xlabel "time (s)"
set ylabel "clearance (m)"
plot csv u 1:9 t "without the wall" lt 2, '' u 1:5 t "around it" lt 1, 0 t "margin of 5 mm" lt 5
GNUPLOT
}
orientation() {
  local arm=${MULTIREACH_ARM:-../shared/robots/panda.urdf:panda_link0:panda_hand}
  IFS=: read -r urdf base tip <<<"$arm"
  if [ ! -e "$urdf" ]; then echo "skipped: orientation ($urdf is not here; see --help)"; return; fi
  scene orientation --urdf "$urdf" --base "$base" --tip "$tip"
  draw orientation 760,480 <<'GNUPLOT'
set multiplot layout 2,1
set logscale y
set format y "10^{%L}"
set yrange [1e-7:3]
set xlabel ""
set ylabel "hand to target (m)"
plot csv u 1:2 t "orientation (m = 6)" lt 1, '' u 1:4 t "pointing (m = 5)" lt 3
set xlabel "time (s)"
set ylabel "angle to target (rad)"
plot csv u 1:3 t "orientation (m = 6)" lt 1, '' u 1:5 t "pointing (m = 5)" lt 3
GNUPLOT
}

all=(limits arrival singularity targets posture-choice push obstacle orientation)
for name in "${@:-${all[@]}}"; do
  [[ " ${all[*]} " == *" $name "* ]] || { echo "figures.sh: unknown picture '$name'; expected one of: ${all[*]}" >&2; exit 2; }
  "$name"
done
