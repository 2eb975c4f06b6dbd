#!/usr/bin/env bash
# launch.sh on a desktop (a terminal, a display, xdg-open): the page is the default and is opened, by a file that only the user reads and
# without the token among the arguments; --text, or a run without a terminal, has none.
bin=$1
[ -x "$bin/multireach-page" ] || { echo "skipped: multireach-page is not built (tools/setup.sh page)"; exit 77; }
command -v script >/dev/null || { echo "skipped: there is no script(1), to make a terminal"; exit 77; }
. "$(dirname "$0")/namespace.sh"
[ "$bin" -ef "$root/build/release/bin" ] || { echo "skipped: launch.sh runs the release build"; exit 77; }
[ -e "$root/build/web/index.html" ] || { echo "skipped: the page is not built (web/build.sh)"; exit 77; }
unset MULTIREACH_ISOLATED WAYLAND_DISPLAY
export DISPLAY=:99
mkdir "$work/programs"
cat >"$work/programs/xdg-open" <<END
#!/bin/sh
echo "\$@" >"$work/opened"
stat -c %a "\$1" >"$work/mode"
cp "\$1" "$work/opened.html"
END
chmod +x "$work/programs/xdg-open"
export PATH="$work/programs:$PATH"
# run OPTION...: on a terminal.
run() {
  rm -f "$work"/opened "$work"/mode "$work"/opened.html
  script -qec "$root/tools/launch.sh --no-setup --isolated --seconds 3 $*" /dev/null >"$work/out" 2>&1 </dev/null
}
run
[ -s "$work/opened.html" ] || failed "no page is opened: $(cat "$work/out")"
grep -q 'url=http://127.0.0.1:[0-9]*/#[^"]*"' "$work/opened.html" || failed "opened: $(cat "$work/opened.html")"
[ "$(cat "$work/mode")" = 600 ] || failed "others can read the address: mode $(cat "$work/mode")"
! grep -q '#' "$work/opened" || failed "the token is among the arguments: $(cat "$work/opened")"
grep -q 'http://127.0.0.1' "$work/out" || failed "the address is not printed"
run --text
[ ! -e "$work/opened" ] || failed "--text opens a page"
! grep -q 'http://' "$work/out" || failed "--text has a page"
"$root/tools/launch.sh" --no-setup --isolated --seconds 2 >"$work/out" 2>&1 </dev/null
if [ -e "$work/opened" ] || grep -q "http://" "$work/out"; then failed "without a terminal there is a page"; fi
! "$root/tools/launch.sh" --no-setup --drake >/dev/null 2>"$work/err" || failed "--drake without --view"
grep -q -- '--drake needs --view' "$work/err" || failed "--drake without --view: $(cat "$work/err")"
finish
