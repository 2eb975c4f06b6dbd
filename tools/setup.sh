#!/usr/bin/env bash
# Installs the Debian packages that are missing for the named parts (with sudo where needed), then configures and builds these parts.
#   tools/setup.sh [--dry-run] [--preset NAME] [PART...]     default part: loop (core for that preset); preset: see CMakePresets.json, default release
# --dry-run: only says what would be downloaded and built.
# Parts:
#   loop       the processes of the loop with the simulated robot, and the programs that launch.sh uses
#   camera     multireach-camera: real cameras, image files, rendered scenes; multireach-videos: import of two videos
#   calibrate  multireach-calibrate
#   replay     multireach-replay
#   page       multireach-page, and the page that it serves (built with npm)
#   studies    multireach-trace, -study, -figures
#   spy        the message types for lcm-spy (Java)
#   docs       Doxygen and cmark-gfm, for tools/docs.sh; builds nothing
#   python     the Python module
#   package    everything that tools/package.sh packs
#   core       the stages as libraries, without LCM
#   tests      everything, with the tests and the benchmarks
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
preset=release
declare -A packages=(
  [core]="g++ cmake ninja-build libopencv-core-dev libopencv-imgproc-dev libeigen3-dev liburdfdom-dev libtinyxml2-dev
    libturbojpeg0-dev libjpeg62-turbo-dev libfcl-dev libhwy-dev libapriltag-dev"
  [loop]="git iproute2 util-linux liblcm-dev liblcm-bin libyaml-cpp-dev libcli11-dev libfmt-dev libspdlog-dev nlohmann-json3-dev
    libmujoco-dev libxxhash-dev liblodepng-dev libsodium-dev liblz4-dev libzstd-dev libbz2-dev"
  [camera]="libopencv-videoio-dev"
  [calibrate]="libopencv-calib3d-dev libopencv-highgui-dev"
  [page]="libcivetweb-dev libopencv-calib3d-dev libopencv-highgui-dev" [replay]="" [studies]="gnuplot-nox" [docs]="doxygen cmark-gfm python3"
  [spy]="liblcm-java libjchart2d-java openjdk-17-jre openjdk-17-jdk-headless"
  [python]="pybind11-dev python3-dev python3-numpy python3-pytest" [package]="python3 file dpkg-dev"
  [tests]="libopencv-dev libgtest-dev libbenchmark-dev liborocos-kdl-dev ccache clang clang-format clang-tidy libclang-rt-14-dev
    opencv-doc libmatio-dev shellcheck systemd libfaketime python3-rosbag python3-sensor-msgs"
)
declare -A targets=(
  [core]="multireach_vision multireach_controller_batch multireach_robot_bridge"
  [loop]="multireach-datagram-guard multireach-vision multireach-controller multireach-bridge multireach-robot-sim multireach-robot-driver multireach-robot-emulator multireach-view multireach-log multireach-robot multireach-publish multireach-key"
  [camera]="multireach-camera multireach-videos" [calibrate]=multireach-calibrate [replay]=multireach-replay [page]=multireach-page
  [studies]="multireach-trace multireach-study multireach-figures"
  [spy]=multireach_types_jar [docs]="" [python]=multireach_python [package]="multireach_pages multireach_vision multireach_controller_batch multireach_robot_bridge" [tests]=all
)
wrong() { echo "setup.sh: $1" >&2; exit 2; }
parts=() dry_run=no
while [ $# -gt 0 ]; do
  case "$1" in
    --help|-h) sed -n '2,17p' "$0" | cut -c3-; exit 0 ;;
    --dry-run) dry_run=yes; shift ;;
    --preset) [ $# -ge 2 ] || wrong "--preset needs a name"; preset=$2; shift 2 ;;
    -*) wrong "unknown option '$1'; see --help" ;;
    *) [ -n "${targets[$1]+is}" ] || wrong "unknown part '$1'; see --help"; parts+=("$1"); shift ;;
  esac
done
if [ ${#parts[@]} -eq 0 ]; then
  parts=(loop)
  [ "$preset" != core ] || parts=(core)
fi
needs=" core "
[ "${parts[*]}" != docs ] || needs=" "
[ "${parts[*]}" = core ] || [ "${parts[*]}" = docs ] || [ "$preset" = core ] || needs+="loop "
for part in "${parts[@]}"; do [[ $needs == *" $part "* ]] || needs+="$part "; done
[[ $needs != *" package "* ]] || needs+="camera calibrate replay page studies spy python "
[[ $needs != *" tests "* ]] || needs+="camera calibrate page studies spy python docs "
wanted=()
for part in $needs; do for package in ${packages[$part]}; do wanted+=("$package"); done; done
[[ $needs != *" page "* ]] || command -v npm >/dev/null || wanted+=(nodejs npm)

log=$(mktemp)
trap 'rm -f "$log"' EXIT
# mawk, Debian's awk, otherwise waits for blocks of 4096 bytes.
awk=(awk)
if awk -W version 2>&1 | grep -q ^mawk; then awk=(awk -W interactive); fi
# progress PATTERN: keeps standard input in the log, and says how far it is, by an awk program for matching lines: on a terminal in one line, elsewhere with
# a line each minute.
progress() {
  if [ ! -t 2 ]; then
    tee -a "$log" | "${awk[@]}" 'BEGIN { said = systime() } '"$1"' systime() >= said + 60 { print text; fflush(); said = systime() }' >&2
    return
  fi
  tee -a "$log" | "${awk[@]}" -v columns="$(tput cols)" "$1"' { printf "\r%s\033[K", substr(text, 1, columns - 1); fflush() } END { printf "\r\033[K" }' >&2
}

missing=()
for package in "${wanted[@]}"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
  sudo=()
  [ "$(id -u)" -eq 0 ] || sudo=(sudo)
  [ $dry_run = yes ] || "${sudo[@]}" apt-get update -qq >&2
  # A line for each archive: its address, file name, size, and digest.
  plan=$(apt-get -qq -y --print-uris --no-install-recommends install "${missing[@]}" 2>/dev/null || true)
  count=$(apt-get -qq -s --no-install-recommends install "${missing[@]}" 2>/dev/null | grep -c '^Inst ' || true)
  doing=Installing
  [ $dry_run = no ] || doing="Would install"
  awk -v names="${missing[*]}" -v doing="$doing" -v count="$count" \
    'NF { size += $3 } END { printf "%s %d Debian packages (download: %.1f MB) for: %s\n", doing, count, size / 1e6, names }' <<<"$plan" >&2
  [ "$count" -gt 0 ] || [ $dry_run = no ] || echo "apt does not know these packages; for numbers, run apt-get update first" >&2
fi
if [ ${#missing[@]} -gt 0 ] && [ $dry_run = no ]; then
  # The status has a descriptor of its own: apt closes it for the packages' own scripts, which write to standard output. The shell
  # inside opens it, because sudo closes all descriptors but the first three.
  if ! "${sudo[@]}" sh -c 'DEBIAN_FRONTEND=noninteractive exec apt-get "$@" 3>&1' apt-get install -y -q --no-install-recommends \
      -o APT::Status-Fd=3 -o Dpkg::Use-Pty=0 "${missing[@]}" 2>&1 |
      progress '/^(dl|pm)status:/ { split($0, part, ":"); text = sprintf("%s packages: %d %%", $0 ~ /^dl/ ? "Downloading" : "Installing", part[3]) } !text { next }'; then
    grep -v '^..status:' "$log" >&2
    echo "setup.sh: apt-get failed" >&2
    exit 1
  fi
fi

cd "$root"
build_targets=()
[[ $needs != *" package "* ]] || read -ra parts <<<"$needs"
for part in "${parts[@]}"; do for target in ${targets[$part]}; do build_targets+=("$target"); done; done
[[ $needs != *" tests "* ]] || build_targets=(all)
if [ $dry_run = yes ]; then
  [ ${#missing[@]} -gt 0 ] || echo "All Debian packages are installed." >&2
  [ -z "${plan:-}" ] || awk 'NF { gsub("\047", "", $1); print $1, $3 }' <<<"$plan"
  [ ${#build_targets[@]} -eq 0 ] || echo "Would build (preset $preset, in build/$preset): ${build_targets[*]}" >&2
  [[ " ${parts[*]} " != *" page "* ]] || echo "Would build the page with npm, which downloads the packages of web/package-lock.json." >&2
  exit 0
fi
[ ${#build_targets[@]} -gt 0 ] || exit 0
[ -d "build/$preset" ] || echo "Building (preset $preset)" >&2
: >"$log"
options=()
[[ $needs != *" python "* || $preset = core ]] || options=(-DMULTIREACH_PYTHON=ON)
[[ $needs != *" tests "* ]] || options+=(-DMULTIREACH_BENCH=ON)
build() { cmake --preset "$preset" "${options[@]}" && cmake --build --preset "$preset" --target "${build_targets[@]}"; }
if ! build 2>&1 | progress '/^\[[0-9]+\// { text = "Building: " $0 } !text { next }'; then
  cat "$log" >&2
  echo "setup.sh: the build failed" >&2
  exit 1
fi
# For the tests, the one that needs the page builds it.
[[ " ${parts[*]} " != *" page "* ]] || web/build.sh >&2
