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
# What is compiled together (cmake/Targets.cmake) is looked at together, which takes half the time, with its sources for headers; FILES
# are looked at one by one.
node - "$build/compile_commands.json" "$top" "$database" "$@" <<'SCRIPT'
const fs = require("node:fs");
const [, , commands, top, out, ...wanted] = process.argv;
const members = (file) => file.includes("/together/")
  ? [...fs.readFileSync(file, "utf8").matchAll(/#include "(.*)"/g)].map(([, member]) => member) : [file];
const inside = (file) => /^(core|store|scene|truth|renderers|metrics|studies|bench|reports)\/.*\.cpp$/.test(file.slice(top.length + 1));
const entries = JSON.parse(fs.readFileSync(commands, "utf8"))
  .map((entry) => ({ ...entry, sources: members(entry.file).filter(inside) }))
  .filter((entry) => entry.sources.length > 0);
const single = entries.flatMap(({ directory, file: unit, command, sources }) =>
  sources.map((file) => ({ directory, file, command: command.replace(unit, file) })));
const files = wanted.length ? wanted : entries.map((entry) => entry.file);
fs.writeFileSync(`${out}/compile_commands.json`, JSON.stringify(wanted.length ? single : entries.map(({ sources, ...entry }) => entry)));
fs.writeFileSync(`${out}/files`, files.map((file) => `${file}\n`).join(""));
SCRIPT
xargs -a "$database/files" -P "$jobs" -n 1 clang-tidy -p "$database" --config-file="$top/.clang-tidy" --quiet \
  2> >(grep -vE '^[0-9]+ warnings? (generated|treated)|^Suppressed|^Use -header' >&2)
