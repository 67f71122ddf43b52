#!/usr/bin/env bash
# Measures the claims of Ranieri et al. 2012 on the displays that lamella makes, and writes
# docs/experiments.md and its figures. Takes about four minutes on two cores.
#
#   scripts/experiments.sh [ID...]
#
# With IDs only these experiments are measured and shown on standard output; the page stays.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

cmake --preset release --log-level=WARNING
cmake --build --preset release --target lamella_experiments
mkdir -p output
if (($#)); then
  build/release/tests/lamella_experiments "$@" >output/experiments-some.json
  exec python3 scripts/experiments.py output/experiments-some.json
fi
build/release/tests/lamella_experiments >output/experiments.json
exec python3 scripts/experiments.py output/experiments.json --page docs/experiments.md \
  --figures docs/experiments
