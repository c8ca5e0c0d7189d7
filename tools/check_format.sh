#!/usr/bin/env bash
# Fails when a tracked C++ file is not formatted as .clang-format says. --fix formats instead.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
mode=(--dry-run --Werror)
[ "${1:-}" = "--fix" ] && mode=(-i)
# `git ls-files` needs a repository; an unpacked archive has none, and nothing there to hold to a format.
if ! git rev-parse --is-inside-work-tree >/dev/null 2>&1; then
  echo "check_format: not a git repository; skipped"
  exit 0
fi
git ls-files -z -- '*.h' '*.cpp' | xargs -0 -r -n 16 -P "$(nproc)" clang-format "${mode[@]}"
