#!/usr/bin/env bash
# Fails when a tracked C++ file is not formatted as .clang-format says. Usage: check_format.sh [--fix] [FILE...]
# --fix formats instead. FILES: these, wherever they lie.
set -euo pipefail
top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
mode=(--dry-run --Werror)
if [ "${1:-}" = "--fix" ]; then
  mode=(-i)
  shift
fi
style=--style=file:$top/.clang-format
if [ $# -gt 0 ]; then
  exec clang-format "$style" "${mode[@]}" "$@"
fi
cd "$top"
# `git ls-files` needs a repository; an unpacked archive has none, and nothing there to hold to a format.
if ! git rev-parse --is-inside-work-tree >/dev/null 2>&1; then
  echo "check_format: not a git repository; skipped"
  exit 0
fi
git ls-files -z -- '*.h' '*.cpp' | xargs -0 -r -n 16 -P "$(nproc)" clang-format "$style" "${mode[@]}"
