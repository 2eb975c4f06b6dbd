#!/usr/bin/env bash
# studies/figures.sh draws every picture of docs/guarantees.md and of the pages of results, and the numbers on the latter are those that
# the programs measure now. What needs an arm that is not here is skipped.
#   tests/live/figures.sh BIN_FOLDER
command -v gnuplot >/dev/null || { echo "skipped: gnuplot is not installed"; exit 77; }
. "$(dirname "${BASH_SOURCE[0]}")/offline.sh"
new=$work/pictures
"$root/studies/figures.sh" --into "$new" >"$work/said" || fail "figures.sh"
cat "$work/said"
pages=(results.md results-protocols.md)
for name in $(cd "$root/docs" && grep -oh '(pictures/guarantees/[a-z-]*\|(results/[a-z0-9-]*\.svg' guarantees.md "${pages[@]}" | sort -u | xargs -n 1 basename -s .svg); do
  grep -q "skipped: $name " "$work/said" || grep -q '</svg>' "$new/$name.svg" || fail "no picture $name"
done

# agree OLD NEW: the same quantities of every figure that NEW has, to a thousandth.
agree() {
  awk -F, '
    function key() { return $1 "," $2 "," $3 "," $5 }
    FNR == 1 { next }
    NR == FNR { old[key()] = $4; figure[key()] = $1; next }
    { made[$1] = 1; seen[key()] = 1 }
    !(key() in old) { print "not in the documents: " key(); bad = 1; next }
    (old[key()] ~ /nan/) != ($4 ~ /nan/) { print key() " is " $4 ", in the documents " old[key()]; bad = 1; next }
    { apart = $4 - old[key()]; if (apart < 0) apart = -apart; size = old[key()] < 0 ? -old[key()] : old[key()] }
    apart > 1e-3 * size + 1e-4 { print key() " is " $4 ", in the documents " old[key()]; bad = 1 }
    END {
      for (k in old) if (figure[k] in made && !(k in seen)) { print "no longer measured: " k; bad = 1 }
      exit bad
    }' "$1" "$2"
}
written=$root/docs/results/measures.csv
agree "$written" "$new/measures.csv" || fail "docs/results/measures.csv is not what is measured: run studies/figures.sh"
# tables_agree PAGE: its tables are those of the written measures.
tables_agree() { /usr/bin/python3 "$root/tools/page_tables.py" --results "$root/docs/results" --into "$work" "$1" && diff "$work/${1##*/}" "$1"; }
for page in "${pages[@]}"; do
  tables_agree "$root/docs/$page" || fail "the tables of docs/$page are not those of measures.csv: run studies/figures.sh"
done

# Both checks can fail.
awk -F, -v OFS=, 'NR == 5 { $4 *= 1.01 } { print }' "$written" >"$work/other.csv"
agree "$written" "$work/other.csv" >/dev/null && fail "a changed number is not noticed"
sed 5d "$written" >"$work/fewer.csv"
agree "$written" "$work/fewer.csv" >/dev/null && fail "a missing number is not noticed"
agree "$work/fewer.csv" "$written" >/dev/null && fail "a number too many is not noticed"
mkdir "$work/changed"
sed 's/^| γ = 0\|^| paper; γ = 0 | 1/&7/' "$root/docs/results.md" >"$work/changed/results.md"
tables_agree "$work/changed/results.md" >/dev/null && fail "a changed table is not noticed"

# Where there is no other arm, what needs one is skipped, and its rows of the docs stay.
mkdir -p "$work/alone/studies" "$work/alone/tools"
cp -r "$root/studies/figures.sh" "$root/studies/figures" "$work/alone/studies/"
cp "$root/tools/page_tables.py" "$work/alone/tools/"
cp -r "$root/docs" "$work/alone/"
ln -s "$root/build" "$root/robots" "$work/alone/"
"$work/alone/studies/figures.sh" fig1 orientation protocol-reaches-panda protocol-lemniscate-iiwa14 >"$work/said" || fail "figures.sh without other arms"
[ "$(grep -c '^skipped: ' "$work/said")" -eq 3 ] || fail "not three are skipped: $(cat "$work/said")"
agree "$written" "$work/alone/docs/results/measures.csv" || fail "figures.sh without other arms changes what is measured"
[ "$(wc -l <"$written")" -eq "$(wc -l <"$work/alone/docs/results/measures.csv")" ] || fail "figures.sh without other arms drops rows"
for page in "${pages[@]}"; do diff "$root/docs/$page" "$work/alone/docs/$page" || fail "figures.sh without other arms changes docs/$page"; done

refuses "unknown picture 'fig99'" "$root/studies/figures.sh" --into "$work/none" fig99
refuses "unknown option '--onto'" "$root/studies/figures.sh" --onto "$work/none"
refuses "--into needs a folder" "$root/studies/figures.sh" --into
[ ! -e "$work/none" ] || fail "a refused run leaves a folder"
exit $failed
