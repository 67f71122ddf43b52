#!/usr/bin/env bash
# From a clean clone to a picture of what a two-layer display would show: installs what is missing,
# builds the program, generates a small capture and takes it through all stages.
#
#   scripts/quickstart.sh [--preset NAME] [--quality NAME] [--out DIR]
#                         default: release, balanced, output/quickstart
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

preset=release
quality=balanced
out=output/quickstart
while (($#)); do
  case "$1" in
    --preset) preset=$2; shift 2 ;;
    --quality) quality=$2; shift 2 ;;
    --out) out=$2; shift 2 ;;
    *) echo "quickstart: unknown argument $1; usage: scripts/quickstart.sh [--preset NAME] [--quality NAME] [--out DIR]" >&2
       exit 2 ;;
  esac
done

say() { printf '\n== %s\n' "$*"; }

say "what is needed"
scripts/setup.sh

say "building the program"
cmake --preset "$preset" --log-level=WARNING
cmake --build --preset "$preset" --target lamella
lamella=build/$preset/lamella

say "a generated capture: photographs of a room, with exact truth"
"$lamella" synth scene room --out "$out/room"

say "from photographs to the display"
"$lamella" run "$out/room/images" --workspace "$out/workspace" --display paper-two-layer \
  --quality "$quality"

say "camera positions against the truth"
"$lamella" compare poses "$out/workspace/poses/transforms.json" "$out/room/transforms.json"

cat <<END

Done. Look at
  $out/workspace/preview/index.html      drag to move the eye
  $out/workspace/depth/                  depth of every photograph
  $out/workspace/frames/                 what the panels show, time slot by time slot
Your own photographs:  $lamella run FOLDER --workspace W --display paper-two-layer
END
