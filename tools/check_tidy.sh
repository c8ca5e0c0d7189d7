#!/usr/bin/env bash
# check_tidy.sh BUILD_DIR JOBS: clang-tidy over every source file of the product (tests are compiled, not linted).
set -euo pipefail
top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$top"
git ls-files -- 'core/*.cpp' 'scene/*.cpp' 'renderers/*.cpp' 'metrics/*.cpp' 'studies/*.cpp' 'bench/*.cpp' 'reports/*.cpp' |
  xargs -P "$2" -n 2 clang-tidy -p "$1" --quiet 2> >(grep -vE '^[0-9]+ warnings? (generated|treated)|^Suppressed|^Use -header' >&2)
