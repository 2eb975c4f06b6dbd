#!/usr/bin/env bash
# The Debian packages in a clean Debian 12: builds them, makes the system with mmdebstrap, installs by the steps of the Containerfile, runs
# the demonstration, the page, man, completion, C++ and Python against the installed files, and removes everything. Prints the times.
#   tests/full/debian_package.sh [--no-build]          as root; needs the Debian packages mmdebstrap and lintian, and some 2 GB in TMPDIR
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
[ "$(id -u)" -eq 0 ] || { echo "debian_package.sh: only root can make a system" >&2; exit 2; }
command -v mmdebstrap >/dev/null || { echo "skipped: mmdebstrap is not here"; exit 77; }
work=$(mktemp -d)
system=$work/system
# Nothing is removed while something is mounted in it.
clean_up() { umount -q "$system/proc" 2>/dev/null; mountpoint -q "$system/proc" || rm -rf --one-file-system "$work"; }
trap clean_up EXIT
failures=0 begin=0 total=0
failed() { echo "FAILED: $1"; failures=$((failures + 1)); }
clock() { date +%s%N; }
# timed NAME COMMAND...: prints how long it takes; what it prints only when it fails.
timed() {
  local name=$1; shift
  begin=$(clock)
  "$@" >"$work/out" 2>&1 || { failed "$name: exit code $?"; tail -n 30 "$work/out"; }
  total=$((($(clock) - begin) / 100000000))
  printf '%6s s  %s\n' "$((total / 10)).$((total % 10))" "$name"
}
inside() { chroot "$system" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 "$@"; }
# expect NAME PATTERN COMMAND...: the command succeeds inside and prints the pattern.
expect() {
  local name=$1 pattern=$2 said; shift 2
  said=$(inside "$@" 2>&1) || failed "$name: exit code $?: $said"
  grep -qE -- "$pattern" <<<"$said" || failed "$name: expected '$pattern' in: $said"
}
# Caches, logs and apt's own records change with every installation.
files() { find "$system" -xdev \( -path '*/var/cache' -o -path '*/var/log' -o -path '*/var/lib/apt' -o -path '*/var/lib/dpkg' -o -path "$system/tmp" -o -path "$system/packages" -o -path "$system/root" -o -path '*/__pycache__' \) -prune -o -print | sed "s,^$system,," | LC_ALL=C sort; }

[ "${1:-}" = --no-build ] || timed "build the packages" "$root/tools/package.sh"
ls "$root"/build/packages/*.deb >/dev/null || exit 1
if command -v lintian >/dev/null; then
  # The maintainer's address is the builder's to set: -DMULTIREACH_MAINTAINER=.
  lintian --allow-root --suppress-tags bogus-mail-host,bogus-mail-host-in-debian-changelog --fail-on error "$root"/build/packages/*.deb || failed "lintian"
fi

mirror=/etc/apt/sources.list.d/debian.sources
[ -r "$mirror" ] || mirror=
timed "make a clean Debian 12" mmdebstrap --variant=minbase --quiet bookworm "$system" ${mirror:+"$mirror"}
mount -t proc proc "$system/proc" || exit 1
cp /etc/resolv.conf "$system/etc/resolv.conf"
mkdir "$system/packages"
cp "$root"/build/packages/*.deb "$system/packages"
files >"$work/before"

mapfile -t steps < <(sed -n '/^FROM .*-slim/,$s/^RUN //p' "$root/Containerfile")
[ ${#steps[@]} -ge 2 ] || failed "the Containerfile has no steps"
first=0
for step in "${steps[@]}"; do timed "$step" inside sh -c "$step"; first=$((first + total)); done
isolated="ip link set lo up && ip route add 224.0.0.0/4 dev lo"
timed "multireach-launch --isolated" unshare --net sh -c "$isolated"' && exec "$@"' sh chroot "$system" env -i PATH=/usr/bin:/bin HOME=/root multireach-launch --isolated --json /tmp/report.json
first=$((first + total))
grep -q "vision against truth" "$work/out" || failed "the demonstration's table"
printf '%6s s  from a clean system to the end of the first demonstration, downloads included\n' "$((first / 10)).$((first % 10))"
expect "multireach" 'Programs: bridge calibrate' multireach --help
expect "dispatcher" 'STEREO_IMAGES' multireach log info /usr/share/multireach/logs/reach.lcm
expect "replay" "$(sed -n 's/  reach.lcm//p' "$root/logs/REPLAY_DIGESTS")" multireach-replay run /usr/share/multireach/logs/reach.lcm
expect "doctor" 'Usage: multireach-doctor' multireach-doctor --help
for program in "$system"/usr/bin/multireach*; do
  name=${program##*/}
  [ -e "$system/usr/share/man/man1/$name.1.gz" ] || failed "$name has no man page"
  # After an empty word: subcommands, which not all have; after -: options, which multireach itself has not.
  expect "completion of $name" '[a-z]' bash -c ". /usr/share/bash-completion/completions/$name; compopt() { :; }; COMP_CWORD=1
    for word in '' -; do COMP_WORDS=($name \"\$word\"); COMPREPLY=(); _${name//-/_}; echo \"\${COMPREPLY[*]}\"; done"
done

timed "install all packages, with compilers" inside sh -c "DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends /packages/*.deb g++ cmake ninja-build pkgconf man-db"
cp -r "$root/tests/package" "$system/tmp/package"
timed "find_package" inside sh -c 'cmake -S /tmp/package -B /tmp/build -G Ninja && cmake --build /tmp/build && /tmp/build/reach /usr/share/multireach/robots/hoap2/hoap2.urdf torso right_hand'
timed "pkg-config" inside sh -c 'g++ -o /tmp/reach /tmp/package/reach.cpp $(pkg-config --cflags --libs multireach) -std=c++20 && /tmp/reach /usr/share/multireach/robots/hoap2/hoap2.urdf torso right_hand'
expect "man" 'NAME' sh -c "man --pager=cat multireach-log || zcat /usr/share/man/man1/multireach-log.1.gz"
expect "Python" 'error 0\.0' python3 /usr/share/doc/python3-multireach/examples/reach.py --robot /usr/share/multireach/robots/hoap2 --target 0.1 -0.12 0.1
expect "camera" 'Usage: multireach-camera' multireach-camera --help

timed "remove everything" inside sh -c "DEBIAN_FRONTEND=noninteractive apt-get purge -y multireach multireach-camera libmultireach-dev python3-multireach g++ cmake ninja-build pkgconf man-db && DEBIAN_FRONTEND=noninteractive apt-get autoremove --purge -y"
files >"$work/after"
left=$(LC_ALL=C comm -13 "$work/before" "$work/after")
grep multireach <<<"$left" && failed "files of multireach stay"
grep -q multireach "$system/etc/passwd" && failed "the user stays"
echo "of other packages stay: $(grep -c . <<<"$left") files${left:+, such as $(head -n 3 <<<"$left" | tr '\n' ' ')}"
[ $failures -eq 0 ] && echo "all held"
exit $((failures > 0))
