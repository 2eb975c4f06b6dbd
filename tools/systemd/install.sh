#!/usr/bin/env bash
# Installs the systemd units and enables the nodes of this computer. Files in /etc/multireach that are there already stay.
#   tools/systemd/install.sh [--root DIR] NODE...     as vision controller bridge robot-sim camera record
# The programs are expected in /usr/local/bin (cmake --install build/release). With --root, nothing is enabled.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
wrong() { echo "install.sh: $1" >&2; exit 2; }
target="" nodes=()
while [ $# -gt 0 ]; do
  case "$1" in
    --help|-h) sed -n '2,4p' "$0" | cut -c3-; exit 0 ;;
    --root) [ $# -ge 2 ] || wrong "--root needs a folder"; target=$2; shift 2 ;;
    record) nodes+=(multireach-record@control multireach-record@images); shift ;;
    vision|controller|bridge|robot-sim|camera) nodes+=("multireach@$1"); shift ;;
    *) wrong "'$1' is not one of vision, controller, bridge, robot-sim, camera, record" ;;
  esac
done
[ ${#nodes[@]} -gt 0 ] || wrong "name the nodes of this computer; see --help"
[ -n "$target" ] || [ "$(id -u)" -eq 0 ] || wrong "only root can install; use sudo"
units=$target/etc/systemd/system
mkdir -p "$units" "$target/etc/multireach" "$target/etc/sysusers.d"
cp "$here"/*.service "$here"/*.target "$units"
for folder in "$here"/*.service.d; do mkdir -p "$units/${folder##*/}"; cp "$folder"/*.conf "$units/${folder##*/}"; done
cp "$here/multireach.sysusers" "$target/etc/sysusers.d/multireach.conf"
cp --no-clobber "$here"/config/*.env "$target/etc/multireach"
[ -z "$target" ] || exit 0
systemd-sysusers
systemctl daemon-reload
systemctl enable multireach.target "${nodes[@]}"
echo "Put robot.yaml, its URDF, and vision.yaml into /etc/multireach; then:  systemctl start multireach.target" >&2
