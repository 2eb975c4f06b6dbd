#!/usr/bin/env bash
# Draws the pictures of the docs from the project's own programs, with gnuplot, and fills in the tables of the results.
#   studies/figures.sh [--into DIR] [NAME...]     default: all names
# Of docs/guarantees.md: limits arrival singularity targets posture-choice push obstacle orientation
# Of docs/results.md:    fig1 fig4 fig7 fig8 fig9 fig10 fig11 fig12 fig13 fig14 fig15 fig16 gamma
# Of docs/results-protocols.md: protocol-reaches-ARM protocol-lemniscate-ARM, ARM being hoap2, panda or iiwa14
# With --into, pictures, measures.csv and both pages of results go to DIR, and the docs stay as they are. The Panda and the iiwa 14 are
# in ../shared/robots; without them, their pictures and tables are left unchanged. The picture "orientation" shows the Panda, or
# the arm in MULTIREACH_ARM (URDF:BASE:TIP; six joints or more).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
guarantees=(limits arrival singularity targets posture-choice push obstacle orientation)
results=(fig1 fig4 fig7 fig8 fig9 fig10 fig11 fig12 fig13 fig14 fig15 fig16 gamma
         protocol-reaches-{hoap2,panda,iiwa14} protocol-lemniscate-{hoap2,panda,iiwa14})
all=("${guarantees[@]}" "${results[@]}")
declare -A arms=([hoap2]=robots/hoap2/hoap2.urdf:torso:right_hand
                 [panda]=../shared/robots/panda.urdf:panda_link0:panda_hand
                 [iiwa14]=../shared/robots/iiwa14.urdf:base:iiwa_link_ee)
into_guarantees=docs/pictures/guarantees into_results=docs/results into_pages=docs
wrong() { echo "figures.sh: $*" >&2; exit 2; }
names=()
while [ $# -gt 0 ]; do
  case "$1" in
    --help|-h) sed -n '2,9p' "$0" | cut -c3-; exit 0 ;;
    --into)
      [ $# -ge 2 ] || wrong "--into needs a folder"
      into_guarantees=$2 into_results=$2 into_pages=$2; shift 2 ;;
    -*) wrong "unknown option '$1'; see --help" ;;
    *)
      [[ " ${all[*]} " == *" $1 "* ]] || wrong "unknown picture '$1'; expected one of: ${all[*]}"
      names+=("$1"); shift ;;
  esac
done
[ ${#names[@]} -gt 0 ] || names=("${all[@]}")
{ command -v gnuplot && [ -x build/release/bin/multireach-figures ]; } >/dev/null || tools/setup.sh studies
mkdir -p "$into_guarantees" "$into_results"
work=$(mktemp -d)
trap 'wait; rm -rf "$work"' EXIT
measures=$into_results/measures.csv

# scene_of NAME: the scene of multireach-figures; arm_of NAME: URDF:BASE:TIP.
scene_of() { case "$1" in protocol-*) echo "${1%-*}" ;; *) echo "$1" ;; esac; }
arm_of() {
  case "$1" in
    orientation) echo "${MULTIREACH_ARM:-${arms[panda]}}" ;;
    protocol-*) echo "${arms[${1##*-}]}" ;;
    *) echo "${arms[hoap2]}" ;;
  esac
}

# compute NAME: the scene's table and its quantities.
compute() {
  local urdf base tip
  IFS=: read -r urdf base tip <<<"$(arm_of "$1")"
  build/release/bin/multireach-figures "$(scene_of "$1")" --urdf "$urdf" --base "$base" --tip "$tip" \
    -o "$work/$1.csv" --measures "$work/$1.measures"
}

# draw NAME FOLDER: the table by the commands of studies/figures/SCENE.gp, whose first line says the size.
draw() {
  local commands
  commands=studies/figures/$(scene_of "$1").gp
  { printf 'set terminal svg size %s font "sans,12" background "white"\nset output "%s/%s.svg"\ncsv = "%s/%s.csv"\n' \
      "$(sed -n '1s/^# size //p' "$commands")" "$2" "$1" "$work" "$1"
    cat studies/figures/style.gp "$commands"; } | gnuplot
  echo "$2/$1.svg"
}

# slim FILE: leaves out gnuplot's empty groups, and what is SVG's default anyway.
slim() { sed -i -z -e 's/ stroke-linecap="butt" stroke-linejoin="miter"//g' -e 's/<g [^>]*>\n<\/g>\n//g' "$1"; }

# take_measures NAME: puts the figure's quantities in place of what measures.csv had of it.
take_measures() {
  { echo "figure,law,quantity,value,unit"
    { [ ! -e "$measures" ] || sed 1d "$measures" | { grep -v "^$1," || true; }
      sed "1d; s/^[^,]*/$1/" "$work/$1.measures"; } | sort -s -t, -k1,1V; } >"$work/measures.csv"
  mv "$work/measures.csv" "$measures"
}

# finish NAME: what is computed goes where it belongs.
finish() {
  if [[ " ${results[*]} " == *" $1 "* ]]; then
    take_measures "$1"
    draw "$1" "$into_results"
    slim "$into_results/$1.svg"
  else
    draw "$1" "$into_guarantees"
  fi
}

# As many scenes at a time as there are processors.
started=() pids=()
for name in "${names[@]}"; do
  arm=$(arm_of "$name")
  if [ ! -e "${arm%%:*}" ]; then echo "skipped: $name (${arm%%:*} is not here; see --help)"; continue; fi
  while [ "$(jobs -rp | wc -l)" -ge "$(nproc)" ]; do wait -n || true; done  # whether it failed is asked for below
  compute "$name" &
  started+=("$name") pids+=($!)
done
for i in "${!started[@]}"; do
  wait "${pids[i]}"
  finish "${started[i]}"
done
if [ -e "$measures" ]; then
  into=()
  [ "$into_pages" = docs ] || into=(--results "$into_results" --into "$into_pages")
  /usr/bin/python3 tools/page_tables.py "${into[@]}" docs/results.md docs/results-protocols.md
fi
