#!/usr/bin/env bash
# Installs what is missing of the Debian packages that multireach needs, then configures and builds.
#   tools/setup.sh [--preset NAME] [--tests] [--target NAME]     preset: see CMakePresets.json; default release;
#                                                                target: what to build; default all
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
preset=release
target=all
packages=(g++ cmake ninja-build git iproute2 util-linux
  liblcm-dev liblcm-bin libglib2.0-dev libopencv-dev libeigen3-dev liburdfdom-dev libyaml-cpp-dev libcli11-dev
  libfmt-dev libspdlog-dev nlohmann-json3-dev libtinyxml2-dev libmujoco-dev libturbojpeg0-dev libjpeg62-turbo-dev libgtest-dev libbenchmark-dev libfcl-dev libhwy-dev
  libxxhash-dev libmatio-dev liblodepng-dev
  liborocos-kdl-dev liblcm-java libjchart2d-java openjdk-17-jre openjdk-17-jdk-headless)
while [ $# -gt 0 ]; do
  case "$1" in
    --preset) preset=$2; shift 2 ;;
    --target) target=$2; shift 2 ;;
    --tests) packages+=(ccache clang clang-format clang-tidy libclang-rt-14-dev opencv-doc gnuplot-nox)
      command -v npm >/dev/null || packages+=(nodejs npm)
      shift ;;
    *) echo "setup.sh: unknown option '$1'" >&2; exit 2 ;;
  esac
done

missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
  echo "Installing Debian packages: ${missing[*]}" >&2
  sudo=()
  [ "$(id -u)" -eq 0 ] || sudo=(sudo)
  # Standard output belongs to the caller's results.
  "${sudo[@]}" apt-get update -qq >&2
  "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}" >&2
fi

cd "$root"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
build() { cmake --preset "$preset" && cmake --build --preset "$preset" --target "$target"; }
[ -d "build/$preset" ] || echo "Building (preset $preset); the first time this takes some minutes" >&2
# On a terminal, ninja's own counter shows how far it is.
watched() {
  if [ ! -t 2 ]; then cat >"$log"; return; fi
  tee "$log" | awk -v columns="$(tput cols)" '/^\[[0-9]/ { printf "\r%s\033[K", substr($0, 1, columns - 1); fflush() } END { printf "\r\033[K" }' >&2
}
if ! build 2>&1 | watched; then
  cat "$log" >&2
  echo "setup.sh: the build failed" >&2
  exit 1
fi
