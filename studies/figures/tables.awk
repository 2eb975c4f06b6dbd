# Fills in the tables of a Markdown page from measures.csv: awk -f tables.awk measures.csv page.md
# What stands between "<!-- measures FIGURE -->" and "<!-- end of measures -->" is replaced by a table of the figure's quantities with
# a column for each law; after "<!-- measures FIGURE by law -->", with a row for each. A figure without measures keeps its table.
BEGIN { FS = "," }
function shown(text) {
  if (text == "") return ""
  if (text ~ /nan/) return "–"
  if (text + 0 != 0 && text + 0 < 1e-3 && text + 0 > -1e-3) return "< 0.001"
  return sprintf(text + 0 >= 10000 ? "%.0f" : "%.4g", text + 0)
}
function row(first, values) { return "| " first " |" values }
function table(figure, by_law,    i, j, line, rule) {
  line = ""; rule = ""
  for (j = 1; j <= (by_law ? quantities[figure] : laws[figure]); ++j) {
    line = line " " (by_law ? quantity[figure, j] : law[figure, j]) " |"
    rule = rule "---|"
  }
  print row("", line)
  print "|---|" rule
  for (i = 1; i <= (by_law ? laws[figure] : quantities[figure]); ++i) {
    line = ""
    for (j = 1; j <= (by_law ? quantities[figure] : laws[figure]); ++j)
      line = line " " shown(by_law ? value[figure, law[figure, i], quantity[figure, j]] : value[figure, law[figure, j], quantity[figure, i]]) " |"
    print row(by_law ? law[figure, i] : quantity[figure, i], line)
  }
}
NR == FNR {
  if (FNR == 1) next
  name = $3 ($5 == "" ? "" : " (" $5 ")")
  if (!(($1, $2) in law_seen)) { law_seen[$1, $2] = 1; law[$1, ++laws[$1]] = $2 }
  if (!(($1, name) in quantity_seen)) { quantity_seen[$1, name] = 1; quantity[$1, ++quantities[$1]] = name }
  value[$1, $2, name] = $4
  next
}
/^<!-- measures / {
  split($0, words, " ")
  print
  if (words[3] in laws) { table(words[3], words[4] == "by"); skipping = 1 }
  next
}
/^<!-- end of measures -->/ { skipping = 0 }
!skipping { print }
