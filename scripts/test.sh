#!/usr/bin/env bash
# Configures, builds and runs all tests. The closing summary of ctest is the last thing printed.
#
#   scripts/test.sh [PRESET] [ctest options]      PRESET: release (default), dev, asan, tsan
#   scripts/test.sh release -R Camera             only the tests whose name matches
#
# Tests on real captures need LAMELLA_DATA, the folder that holds them; without it (and without
# ../shared/data beside the checkout) they are skipped with a line that says so.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

preset=release
if (($#)) && [[ "$1" != -* ]]; then
  preset=$1
  shift
fi

if [[ -z "${LAMELLA_DATA:-}" && -d ../shared/data ]]; then
  LAMELLA_DATA=$(cd ../shared/data && pwd)
fi
if [[ -n "${LAMELLA_DATA:-}" ]]; then
  export LAMELLA_DATA
else
  unset LAMELLA_DATA  # their tests say so and are skipped
fi

scripts/setup.sh
cmake --preset "$preset" --log-level=WARNING
cmake --build --preset "$preset"
ctest --test-dir "build/$preset" --output-on-failure -j "$(nproc)" "$@" </dev/null
