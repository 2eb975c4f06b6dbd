# To be sourced by a test that has `fail` and the folder $work.
# refuses SENTENCE COMMAND...: exit code 2, and on standard error one line with this sentence.
refuses() {
  local sentence=$1; shift
  "$@" >"$work/out" 2>"$work/err"
  local code=$?
  [ $code -eq 2 ] || fail "exit code $code, expected 2: $*"
  { grep -qF -- "$sentence" "$work/err" && [ "$(wc -l <"$work/err")" -eq 1 ]; } || fail "'$sentence' is not all of '$(cat "$work/err")'"
}
