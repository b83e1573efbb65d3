#!/usr/bin/env bash
# Formatting check: C and C++ sources are as clang-format 14 writes them. Other versions format differently.
#
#   tools/check_format.sh         lists files that differ; exit code 1 if there are any
#   tools/check_format.sh --fix   rewrites them
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

for name in clang-format-14 clang-format; do
  if command -v "$name" > /dev/null && [[ $("$name" --version) == *"version 14."* ]]; then formatter=$name; break; fi
done
if [ -z "${formatter:-}" ]; then
  echo "check_format.sh: not checked: clang-format 14 is not installed (Debian 12 has it: clang-format-14)"
  exit 0
fi
case "${1:-}" in
  '') mode=(--dry-run -Werror) ;;
  --fix) mode=(-i) ;;
  *) echo "check_format.sh: unknown option $1 (there is --fix)" >&2; exit 2 ;;
esac
list=$(mktemp)
trap 'rm -f "$list"' EXIT
git ls-files -z '*.c' '*.cpp' '*.h' '*.hpp' | xargs -0 -P "$(nproc)" -n 64 "$formatter" "${mode[@]}" 2>&1 |
  { grep -E 'warning: code should|error: code should' || true; } | cut -d: -f1 | sort -u > "$list" || true
if [ -s "$list" ]; then
  cat "$list"
  echo "check_format.sh: the files above are not formatted: tools/check_format.sh --fix"
  exit 1
fi
echo "check_format.sh: all files are formatted"
