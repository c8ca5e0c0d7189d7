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
# Without what is g++ alone: its precompiled headers, which clang cannot read, and warnings that clang does not know. What is
# compiled together (cmake/Targets.cmake) is looked at one by one.
node - "$build/compile_commands.json" >"$database/compile_commands.json" <<'SCRIPT'
const fs = require("node:fs");
const gpp = / -include \S*cmake_pch\.hxx| -fpch-preprocess| -Wno-(restrict|stringop-[a-z]+|array-bounds|maybe-uninitialized|subobject-linkage)/g;
const entries = JSON.parse(fs.readFileSync(process.argv[2], "utf8")).flatMap((entry) => {
  const command = entry.command.replace(gpp, "");
  if (!entry.file.includes("/together/")) return [{ ...entry, command }];
  return [...fs.readFileSync(entry.file, "utf8").matchAll(/#include "(.*)"/g)].map(([, file]) => ({
    directory: entry.directory, file, command: command.replace(entry.file, file),
  }));
});
console.log(JSON.stringify(entries));
SCRIPT
files() {
  if [ $# -gt 0 ]; then printf '%s\n' "$@"; else
    git ls-files -- 'core/*.cpp' 'store/*.cpp' 'scene/*.cpp' 'renderers/*.cpp' 'metrics/*.cpp' 'studies/*.cpp' 'bench/*.cpp' 'reports/*.cpp'
  fi
}
files "$@" | xargs -P "$jobs" -n 2 clang-tidy -p "$database" --config-file="$top/.clang-tidy" --quiet \
  2> >(grep -vE '^[0-9]+ warnings? (generated|treated)|^Suppressed|^Use -header' >&2)
