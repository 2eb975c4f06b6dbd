#!/usr/bin/env bash
# Draws the table of a sweep (multireach-replay sweep) with gnuplot: the first key's values along the axis, a line for each
# combination of the other keys' values.
#   tools/sweep_picture.sh TABLE.csv -o PICTURE.svg [FIGURE...]     default: hand_error_mm_p50 settle_s_p50 vision_error_mm_p95 lost_frames
set -euo pipefail
wrong() { echo "sweep_picture.sh: $*" >&2; exit 2; }
table="" picture="" figures=()
while [ $# -gt 0 ]; do
  case "$1" in
    --help|-h) sed -n '2,4p' "$0" | cut -c3-; exit 0 ;;
    -o|--output) [ $# -ge 2 ] || wrong "$1 needs a file"; picture=$2; shift 2 ;;
    -*) wrong "unknown option '$1'; see --help" ;;
    *) if [ -z "$table" ]; then table=$1; else figures+=("$1"); fi; shift ;;
  esac
done
{ [ -n "$table" ] && [ -n "$picture" ]; } || wrong "expected TABLE.csv -o PICTURE.svg; see --help"
[ -r "$table" ] || wrong "$table: cannot be read"
command -v gnuplot >/dev/null || wrong "gnuplot is missing: apt install gnuplot-nox"
[ ${#figures[@]} -gt 0 ] || figures=(hand_error_mm_p50 settle_s_p50 vision_error_mm_p95 lost_frames)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# For each figure a file of rows "axis value, figure", and an empty line between lines of the picture, each with its title; the key's name
# in axis.txt. Values in quotes hold commas.
awk -v work="$work" -v wanted="${figures[*]}" '
  function cells(line,   n, i, c, inside) {
    n = 1; split("", cell); cell[1] = ""
    for (i = 1; i <= length(line); ++i) {
      c = substr(line, i, 1)
      if (c == "\"") inside = !inside
      else if (c == "," && !inside) cell[++n] = ""
      else cell[n] = cell[n] c
    }
    return n
  }
  NR == 1 {
    columns = cells($0)
    for (i = 1; i <= columns; ++i) { name[i] = cell[i]; at[cell[i]] = i }
    if (name[1] != "index" || !("succeeded" in at) || at["succeeded"] < 3) { print "is not the table of a sweep"; exit }
    print name[2] >(work "/axis.txt")
    count = split(wanted, figure, " ")
    for (f = 1; f <= count; ++f) if (!(figure[f] in at)) { print "has no column \x27" figure[f] "\x27"; exit }
    next
  }
  {
    cells($0)
    title = ""
    for (i = 3; i < at["succeeded"]; ++i) title = title (title == "" ? "" : ", ") name[i] " " cell[i]
    if (!(title in line)) { line[title] = ++lines; titles[lines] = title }
    for (f = 1; f <= count; ++f) {
      value = cell[at[figure[f]]]
      rows[f, line[title]] = rows[f, line[title]] "\"" cell[2] "\" " (value == "" ? "NaN" : value) "\n"
    }
  }
  END {
    for (f = 1; f <= count; ++f)
      for (l = 1; l <= lines; ++l) printf "\"%s\"\n%s\n\n", titles[l] == "" ? "-" : titles[l], rows[f, l] >(work "/" figure[f] ".txt")
    if (lines) print lines >(work "/lines.txt")
  }' "$table" >"$work/fault"
[ ! -s "$work/fault" ] || wrong "$table: $(cat "$work/fault")"
[ -s "$work/lines.txt" ] || wrong "$table: has no rows"

{
  echo "set terminal svg size 760,$((260 * ${#figures[@]})) font 'sans,12' background 'white'"
  echo "set output '$work/picture.svg'"
  echo "set multiplot layout ${#figures[@]},1"
  echo "set grid lc '#dddddd'; set style data linespoints; set key autotitle columnhead noenhanced outside right top"
  echo "set offsets graph 0.05, graph 0.05, graph 0.05, graph 0.05"
  # Values that are no numbers, as lists, stand side by side.
  numbers=$(awk 'NF == 2 && $1 ~ /^"/ { gsub(/"/, "", $1); if ($1 + 0 != $1) { print "no"; exit } }' "$work/${figures[0]}.txt")
  using="1:2"
  [ -z "$numbers" ] || using="0:2:xtic(1)"
  for figure in "${figures[@]}"; do
    echo "set ylabel '$figure' noenhanced; set xlabel '$(cat "$work/axis.txt")' noenhanced"
    [ "$(cat "$work/lines.txt")" -gt 1 ] || echo "unset key"
    echo "plot for [l = 0:$(($(cat "$work/lines.txt") - 1))] '$work/$figure.txt' index l using $using pt 7 ps 0.5"
  done
} | gnuplot 2>"$work/said" || wrong "gnuplot: $(cat "$work/said")"
mv "$work/picture.svg" "$picture"
