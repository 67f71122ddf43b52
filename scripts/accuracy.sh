#!/usr/bin/env bash
# Measures what lamella reaches and what it costs, with commands anyone can run, and writes
# docs/accuracy.md and the table in README.md. Takes about five hours on two idle cores.
#
#   scripts/accuracy.sh [--fresh] [--only true-depth|calibration|trade [--recorded]]
#
# Needs the real captures in LAMELLA_DATA (or ../shared/data beside the checkout); the generated
# capture is made on the way. Measurements that are on record already (docs/measurements/) are kept;
# --fresh takes all of them anew, as a change of the program's code asks for. --only measures and
# writes one section of the page; with --recorded it is written from what is on record.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

fresh=false
only=()
while (($#)); do
  case "$1" in
    --fresh) fresh=true; shift ;;
    --only) only+=(--only "$2"); shift 2 ;;
    --recorded) only+=(--recorded); shift ;;
    *) echo "accuracy: unknown argument $1; usage: scripts/accuracy.sh [--fresh] [--only true-depth|calibration|trade [--recorded]]" >&2; exit 2 ;;
  esac
done

data=${LAMELLA_DATA:-../shared/data}
if [[ ! -d "$data" ]]; then
  echo "accuracy: $data does not exist; set LAMELLA_DATA to the folder of captures" >&2
  exit 3
fi

scripts/setup.sh
cmake --preset release --log-level=WARNING
cmake --build --preset release --target lamella pipeline_test
$fresh && rm -rf docs/measurements
exec python3 scripts/accuracy.py --program build/release/lamella --data "$data" \
  --work output/accuracy --records docs/measurements --page docs/accuracy.md --readme README.md "${only[@]}"
