#!/usr/bin/env bash
# Format, include arrows, file sizes, clang-tidy. Exits 1 where any of them has a complaint.
#
#   scripts/check.sh [--all]
#
# clang-tidy looks at the .cc files that changed since origin/main (or, on main itself, in the last
# commit); --all looks at every one, which takes many minutes.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

all=false
while (($#)); do
  case "$1" in
    --all) all=true; shift ;;
    *) echo "check: unknown argument $1; usage: scripts/check.sh [--all]" >&2; exit 2 ;;
  esac
done

failed=false
fail() { echo "check: $*" >&2; failed=true; }

mapfile -t sources < <(git ls-files '*.h' '*.cc')

echo "check: format of ${#sources[@]} files"
printf '%s\0' "${sources[@]}" | xargs -0 clang-format --dry-run -Werror \
  || fail "format: run clang-format -i on the files above"

echo "check: include arrows"
scripts/check_includes.py || fail "include arrows (DESIGN: siblings never include siblings)"

echo "check: file sizes"
max_lines=600
max_bytes=500000
for file in "${sources[@]}"; do
  lines=$(wc -l <"$file")
  ((lines <= max_lines)) || fail "$file has $lines lines, at most $max_lines: split it by noun or method"
done
while IFS= read -r file; do
  bytes=$(stat -c %s "$file")
  ((bytes <= max_bytes)) || fail "$file has $bytes bytes, at most $max_bytes"
done < <(git ls-files)

changed_sources() {
  if $all; then
    git ls-files '*.cc'
    return
  fi
  local base
  base=$(git merge-base HEAD origin/main 2>/dev/null || true)
  if [[ -z "$base" || "$base" == "$(git rev-parse HEAD)" ]]; then
    base=$(git rev-parse -q --verify HEAD~ || true)
  fi
  [[ -n "$base" ]] || return 0
  git diff --name-only --diff-filter=d "$base" -- '*.cc'
}
mapfile -t tidy < <(changed_sources)
echo "check: clang-tidy on ${#tidy[@]} files"
if ((${#tidy[@]})); then
  cmake --preset files --log-level=WARNING >/dev/null
  scripts/tidy.py build/files "${tidy[@]}" || fail "clang-tidy"
fi

$failed && exit 1
echo "check: all good"
