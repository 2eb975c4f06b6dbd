# To be sourced by a test that has `fail` and the folder $work.
# ends_with CODE SENTENCE COMMAND...: this exit code, and on standard error one line with this sentence.
ends_with() {
  local expected=$1 sentence=$2; shift 2
  "$@" >"$work/out" 2>"$work/err"
  local code=$?
  [ $code -eq "$expected" ] || fail "exit code $code, expected $expected: $*"
  { grep -qF -- "$sentence" "$work/err" && [ "$(wc -l <"$work/err")" -eq 1 ]; } || fail "'$sentence' is not all of '$(cat "$work/err")'"
}
# refuses SENTENCE COMMAND...: wrong usage or input.
refuses() { ends_with 2 "$@"; }
