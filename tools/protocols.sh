#!/usr/bin/env bash
# The tables and pictures of docs/results-protocols.md: two tasks of Pattacini et al. (IROS 2010) under several laws.
#   tools/protocols.sh [--into DIR]     prints the tables as Markdown; pictures go to DIR, default docs/results
# The Hoap2, and of ../shared/robots the arms that are there.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
pictures=docs/results
case "${1:-}" in
  --help|-h) sed -n '2,4p' "$0" | cut -c3-; exit 0 ;;
  --into) pictures=${2:?--into needs a folder} ;;
  "") ;;
  *) echo "protocols.sh: unknown argument '$1'; see --help" >&2; exit 2 ;;
esac
{ command -v gnuplot && [ -x build/release/bin/multireach-figures ]; } >/dev/null || tools/setup.sh --tests
mkdir -p "$pictures"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
arms=("Hoap2:hoap2:robots/hoap2/hoap2.urdf:torso:right_hand"
      "Panda:panda:../shared/robots/panda.urdf:panda_link0:panda_hand"
      "iiwa 14:iiwa14:../shared/robots/iiwa14.urdf:base:iiwa_link_ee")
present=()
for arm in "${arms[@]}"; do
  IFS=: read -r name short urdf base tip <<<"$arm"
  if [ ! -e "$urdf" ]; then echo "skipped: $name ($urdf is not here)" >&2; continue; fi
  present+=("$name:$short")
  for scene in reaches reaches-measures lemniscate lemniscate-measures; do
    build/release/bin/multireach-figures "protocol-$scene" --urdf "$urdf" --base "$base" --tip "$tip" --csv "$work/$scene-$short.csv"
  done
done

laws='BEGIN { FS = ","; law[0] = "guarded"; law[1] = "paper"; law[2] = "paper, literal"; law[3] = "damped least squares"
  law[4] = "guarded, orientation held"; law[-1] = "(minimum jerk, 1.5 s)" }
  function mm(x) { return x == "nan" ? "-" : sprintf("%.3f", 1000 * x) }
  function beyond(x) { return x > 0 ? sprintf("%.4f", x) : 0 }
  function degrees(law, x) { return law == 4 ? sprintf("%.3f", 57.29578 * x) : "" }'
echo "| arm | law | error at the end, mm: median | most | path / distance: median | most | within 1 %, s | normalised jerk | speed peaks: most | hand's jerk, RMS, m/s³ | joints' jerk, RMS, rad/s³ | beyond a limit, rad | fastest joint, of its limit | turned, ° |"
echo "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
for arm in "${present[@]}"; do
  awk -v arm="${arm%:*}" "$laws"' NR > 1 && $1 == -1 {
    printf "| %s | %s | | | 1 | 1 | %.2f | %.0f | %d | %.2f | | | | |\n", arm, law[$1], $7, $8, $10, $11; next }
    NR > 1 { printf "| %s | %s | %s | %s | %.3f | %.3f | %.2f | %.0f | %d | %.2f | %.1f | %s | %.2f | %s |\n", arm, law[$1], mm($3), mm($4), $5, $6,
      $7, $8, $10, $11, $12, beyond($13), $14, degrees($1, $15) }' "$work/reaches-measures-${arm#*:}.csv"
done
echo
echo "| arm | law | velocity told | error, mm: RMS | most | off the curve, mm: RMS | most | path / curve | hand's jerk, RMS, m/s³ | joints' jerk, RMS, rad/s³ | beyond a limit, rad | fastest joint, of its limit | turned, ° |"
echo "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
for arm in "${present[@]}"; do
  awk -v arm="${arm%:*}" "$laws"' NR > 1 { printf "| %s | %s | %s | %s | %s | %s | %s | %.4f | %.3f | %.3f | %s | %.2f | %s |\n", arm, law[$1],
    ($2 ? "yes" : "no"), mm($4), mm($5), mm($6), mm($7), $8, $9, $10, beyond($11), $12, degrees($1, $13)
    if ($3 < 299.9) printf "  (ended after %.1f s: not finite)\n", $3 }' "$work/lemniscate-measures-${arm#*:}.csv"
done

# draw NAME SIZE: gnuplot commands on standard input.
draw() {
  { printf 'set terminal svg size %s font "sans,12" background "white"\nset output "%s/%s.svg"\n' "$2" "$pictures" "$1"
    printf 'set datafile separator ","\nset key autotitle columnhead noenhanced outside right top\nset grid lc "#dddddd"\nset style data lines\n'
    printf 'set linetype 1 lc "#1f6fb4" lw 2\nset linetype 2 lc "#d1495b" lw 2\nset linetype 3 lc "#3a9d5d" lw 2\n'
    printf 'set linetype 4 lc "#8a5fb0" lw 2\nset linetype 5 lc "#777777" lw 1 dt 2\n'
    cat; } | gnuplot
  echo "$pictures/$1.svg" >&2
}
for arm in "${present[@]}"; do
  name=${arm%:*} short=${arm#*:}
  [ "$short" != panda ] || continue  # its pictures are much the same as the Hoap2's
  draw "protocol-reaches-$short" 860,720 <<GNUPLOT
csv = "$work/reaches-$short.csv"
set multiplot layout 3,1 title "$name: one reach of 20"
set xrange [0:2.5]
set xlabel "time (s)"
set ylabel "hand's speed (m/s)"
plot csv u 1:3 t "guarded" lt 1, '' u 1:5 t "paper" lt 2, '' u 1:7 t "paper, literal" lt 3 dt 3, '' u 1:9 t "damped l. s." lt 4
set ylabel "hand to target (m)"
set logscale y
set format y "10^{%L}"
set yrange [1e-6:1]
plot csv u 1:2 t "guarded" lt 1, '' u 1:4 t "paper" lt 2, '' u 1:6 t "paper, literal" lt 3 dt 3, '' u 1:8 t "damped l. s." lt 4
unset logscale y
set format y "%g"
set autoscale x
set autoscale y
set xlabel "along the line between the points (m), there and back"
set ylabel "aside of it (mm)"
plot csv u 10:(1000*\$11) t "guarded" lt 1, '' u 12:(1000*\$13) t "paper" lt 2, '' u 14:(1000*\$15) t "paper, literal" lt 3 dt 3, \
  '' u 16:(1000*\$17) t "damped l. s." lt 4
GNUPLOT
  draw "protocol-lemniscate-$short" 860,820 <<GNUPLOT
csv = "$work/lemniscate-$short.csv"
set multiplot layout 3,1 title "$name: lemniscate"
set xlabel "y in W (m)"
set ylabel "z in W (m)"
set size ratio -1
plot csv u (\$1 < 10 ? NaN : \$10):11 t "damped l. s." lt 4, '' u (\$1 < 10 ? NaN : \$6):7 t "paper" lt 2, '' u (\$1 < 10 ? NaN : \$4):5 t "guarded" lt 1, \
  '' u 2:3 t "target" lt 5
set size noratio
set xlabel ""
set ylabel "hand to target (mm),\nvelocity not told"
set logscale y
set yrange [0.01:300]
set xrange [0:300]
plot csv u 1:(1000*\$12) t "guarded" lt 1, '' u 1:(1000*\$13) t "paper" lt 2, '' u 1:(1000*\$15) t "damped l. s." lt 4
set xlabel "time (s)"
set ylabel "hand to target (mm),\nvelocity told"
plot csv u 1:(1000*\$16) t "guarded" lt 1, '' u 1:(1000*\$17) t "paper" lt 2, '' u 1:(1000*\$19) t "damped l. s." lt 4
GNUPLOT
done
