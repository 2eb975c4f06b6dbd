#!/usr/bin/env bash
# Draws the pictures of the docs from the project's own programs, with gnuplot, and fills in the tables of docs/results.md.
#   tools/figures.sh [--into DIR] [NAME...]     default: all names
# Of docs/guarantees.md: limits arrival singularity targets posture-choice push obstacle orientation
# Of docs/results.md:    fig1 fig4 fig7 fig8 fig9 fig10 fig11 fig12 fig13 fig14 fig15 fig16 gamma
# With --into, pictures, measures.csv and results.md all go to DIR, and the docs stay as they are. The picture "orientation" needs
# an arm of six joints or more: ../shared/robots/panda.urdf, or the one that MULTIREACH_ARM names (URDF:BASE:TIP).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
guarantees=(limits arrival singularity targets posture-choice push obstacle orientation)
results=(fig1 fig4 fig7 fig8 fig9 fig10 fig11 fig12 fig13 fig14 fig15 fig16 gamma)
all=("${guarantees[@]}" "${results[@]}")
into_guarantees=docs/pictures/guarantees into_results=docs/results page=docs/results.md
wrong() { echo "figures.sh: $*" >&2; exit 2; }
names=()
while [ $# -gt 0 ]; do
  case "$1" in
    --help|-h) sed -n '2,7p' "$0" | cut -c3-; exit 0 ;;
    --into)
      [ $# -ge 2 ] || wrong "--into needs a folder"
      into_guarantees=$2 into_results=$2 page=$2/results.md; shift 2 ;;
    -*) wrong "unknown option '$1'; see --help" ;;
    *)
      [[ " ${all[*]} " == *" $1 "* ]] || wrong "unknown picture '$1'; expected one of: ${all[*]}"
      names+=("$1"); shift ;;
  esac
done
[ ${#names[@]} -gt 0 ] || names=("${all[@]}")
{ command -v gnuplot && [ -x build/release/bin/multireach-figures ]; } >/dev/null || tools/setup.sh --tests
mkdir -p "$into_guarantees" "$into_results"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
hoap2=(--urdf robots/hoap2/hoap2.urdf --base torso --tip right_hand)
measures=$into_results/measures.csv

scene() { build/release/bin/multireach-figures "$1" "${@:2}" --csv "$work/$1.csv"; }

# draw NAME FOLDER: the scene's table by the commands of tools/figures/NAME.gp, whose first line says the size.
draw() {
  local commands=tools/figures/$1.gp
  { printf 'set terminal svg size %s font "sans,12" background "white"\nset output "%s/%s.svg"\ncsv = "%s/%s.csv"\n' \
      "$(sed -n '1s/^# size //p' "$commands")" "$2" "$1" "$work" "$1"
    cat tools/figures/style.gp "$commands"; } | gnuplot
  echo "$2/$1.svg"
}

# slim FILE: leaves out gnuplot's empty groups, and what is SVG's default anyway.
slim() { sed -i -z -e 's/ stroke-linecap="butt" stroke-linejoin="miter"//g' -e 's/<g [^>]*>\n<\/g>\n//g' "$1"; }

# take_measures NAME: puts the figure's quantities in place of what measures.csv had of it.
take_measures() {
  { echo "figure,law,quantity,value,unit"
    { [ ! -e "$measures" ] || sed 1d "$measures" | { grep -v "^$1," || true; }
      sed 1d "$work/$1.measures"; } | sort -s -t, -k1,1V; } >"$work/measures.csv"
  mv "$work/measures.csv" "$measures"
}

for name in "${names[@]}"; do
  arm=("${hoap2[@]}")
  if [ "$name" = orientation ]; then
    IFS=: read -r urdf base tip <<<"${MULTIREACH_ARM:-../shared/robots/panda.urdf:panda_link0:panda_hand}"
    if [ ! -e "$urdf" ]; then echo "skipped: orientation ($urdf is not here; see --help)"; continue; fi
    arm=(--urdf "$urdf" --base "$base" --tip "$tip")
  fi
  if [[ " ${results[*]} " == *" $name "* ]]; then
    scene "$name" "${arm[@]}" --measures "$work/$name.measures"
    take_measures "$name"
    draw "$name" "$into_results"
    slim "$into_results/$name.svg"
  else
    scene "$name" "${arm[@]}"
    draw "$name" "$into_guarantees"
  fi
done
if [ -e "$measures" ]; then
  awk -f tools/figures/tables.awk "$measures" docs/results.md >"$work/results.md"
  mv "$work/results.md" "$page"
fi
