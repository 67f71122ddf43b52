#!/usr/bin/env bash
# Installs what building, testing and running lamella needs, from Debian 12's own packages.
# Runs as root or through sudo, asks nothing, and returns at once where all is there.
#
#   scripts/setup.sh            everything
#   scripts/setup.sh --list     prints the packages and installs nothing
set -euo pipefail

packages=(
  # to build
  g++ cmake ninja-build ccache pkg-config git
  # libraries (docs/decisions/ says why where it is not obvious)
  libeigen3-dev libtbb-dev libopenimageio-dev openimageio-tools libembree-dev libssl-dev
  libcli11-dev libtomlplusplus-dev nlohmann-json3-dev libfmt-dev libxxhash-dev libhwy-dev
  libsqlite3-dev libceres-dev libgoogle-glog-dev libopencv-dev
  # programs that lamella runs
  colmap
  # to test and to check
  libgtest-dev libgmock-dev libbenchmark-dev python3 chromium chromium-driver clang-format
  clang-tidy clang libclang-rt-dev
)

if [[ "${1:-}" == --list ]]; then
  printf '%s\n' "${packages[@]}"
  exit 0
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ "$status" == installed ]] || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  echo "setup: all ${#packages[@]} packages are installed"
  exit 0
fi

as_root=()
if ((EUID != 0)); then
  command -v sudo >/dev/null || {
    echo "setup: needs root to install: ${missing[*]}; run it as root or install sudo" >&2
    exit 5
  }
  as_root=(sudo)
fi

echo "setup: installing ${missing[*]}"
apt_options=(-y -q -o Dpkg::Use-Pty=0 --no-install-recommends)
"${as_root[@]}" apt-get update -q </dev/null
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get install "${apt_options[@]}" "${missing[@]}" </dev/null
echo "setup: done"
