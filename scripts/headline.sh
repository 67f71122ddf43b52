#!/usr/bin/env bash
# The whole way from photographs to display frames and preview beside COLMAP's own default sparse
# chain (features, exhaustive matching, mapping; on the processor) on the same photographs, stage by
# stage. Takes a few minutes.
#
#   scripts/headline.sh [--photographs DIR] [--quality NAME] [--threads N] [--rounds N]
#                       default: Sceaux castle, balanced, all cores, 1
#
# Needs the real captures in LAMELLA_DATA (or ../shared/data beside the checkout) where no
# photographs are named.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/setup.sh
cmake --preset release --log-level=WARNING
cmake --build --preset release --target lamella
exec python3 scripts/headline.py --program build/release/lamella \
  --photographs "${LAMELLA_DATA:-../shared/data}/handheld/sceaux_castle/images" "$@"
