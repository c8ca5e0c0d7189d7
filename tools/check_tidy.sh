#!/usr/bin/env bash
# check_tidy.sh BUILD_DIR JOBS [FILE...]: clang-tidy over every source file of the product, or over FILES (tests are compiled, not
# linted).
set -euo pipefail
top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$top"
[ $# -ge 2 ] || { echo "usage: check_tidy.sh BUILD_DIR JOBS [FILE...]" >&2; exit 2; }
build=$1
jobs=$2
shift 2
[ -f "$build/compile_commands.json" ] || { echo "check_tidy: no compile_commands.json in $build; configure first" >&2; exit 2; }
database=$(mktemp -d)
trap 'rm -rf "$database"' EXIT
# What is g++ alone: its precompiled headers, which clang cannot read, and warnings that clang does not know.
sed -E 's/ -include [^ ]*cmake_pch\.hxx//; s/ -fpch-preprocess//; s/ -Wno-(restrict|stringop-[a-z]+|array-bounds|maybe-uninitialized)//g' "$build/compile_commands.json" >"$database/compile_commands.json"
files() {
  if [ $# -gt 0 ]; then printf '%s\n' "$@"; else
    git ls-files -- 'core/*.cpp' 'store/*.cpp' 'scene/*.cpp' 'renderers/*.cpp' 'metrics/*.cpp' 'studies/*.cpp' 'bench/*.cpp' 'reports/*.cpp'
  fi
}
files "$@" | xargs -P "$jobs" -n 2 clang-tidy -p "$database" --config-file="$top/.clang-tidy" --quiet \
  2> >(grep -vE '^[0-9]+ warnings? (generated|treated)|^Suppressed|^Use -header' >&2)
