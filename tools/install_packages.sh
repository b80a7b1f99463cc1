#!/usr/bin/env bash
# Installs the Debian 12 packages that are missing; asks apt for nothing when none is.
# Usage: tools/install_packages.sh [build] [demo] [test] [ci]
set -euo pipefail

build=(cmake ninja-build g++ pkg-config libgdal-dev libhdf5-dev libzstd-dev libxxhash-dev libglm-dev libfmt-dev
       nlohmann-json3-dev libcli11-dev libepoxy-dev libegl-dev libglfw3-dev libimgui-dev
       libmeshoptimizer-dev libpng-dev libgtest-dev libgmock-dev libbenchmark-dev)
# What runs it: Mesa's software OpenGL (a GPU's own driver goes before it) and the video encoder.
demo=(libegl1 libegl-mesa0 libgl1-mesa-dri libgl1 ffmpeg libncarg-data)
test=("${demo[@]}" xvfb xauth xdotool bubblewrap time)
ci=("${test[@]}" strace bubblewrap git clang libclang-rt-14-dev clang-format clang-tidy)

missing=()
for set in "${@:-build}"; do
  declare -n packages=$set
  for package in "${packages[@]}"; do
    state=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
    [[ $state == installed || " ${missing[*]} " == *" $package "* ]] || missing+=("$package")
  done
done
((${#missing[@]})) || exit 0

as_root=()
if ((EUID != 0)); then
  command -v sudo >/dev/null ||
    { echo "packages missing: ${missing[*]}: install them as root, then run this again" >&2; exit 1; }
  as_root=(sudo)
fi
echo "Installing ${#missing[@]} Debian packages (the first time takes a few minutes) ..."
log=$(mktemp)
trap 'rm -f "$log"' EXIT
apt() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq "$@" >>"$log" 2>&1; }
if ! { apt update && apt install -y --no-install-recommends "${missing[@]}"; }; then
  tail -n 5 "$log" >&2
  echo "apt-get failed: packages wanted: ${missing[*]}" >&2
  exit 1
fi
