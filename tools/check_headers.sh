#!/usr/bin/env bash
# Fails when a header does not compile alone. Usage: check_headers.sh BUILD_DIR (a configured build, for its include paths)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=${1:-build/release}
commands=$build/compile_commands.json
[ -f "$commands" ] || { echo "check_headers: no $commands; configure first" >&2; exit 2; }

# Every include path and definition that any target uses, once.
flags=$(grep -o '"command": ".*\.cpp"' "$commands" | grep -oE '(-isystem [^ ]+|-I[^ ]+|-DGLM[^ ]+|-DFMT[^ ]+)' | sort -u)
compile() {
  local header=$1
  printf '#include "%s"\n' "$header" |
    g++ -std=c++20 -fsyntax-only -Wall -Wextra -Wno-missing-field-initializers $flags -I. -x c++ - ||
    { echo "check_headers: $header does not compile alone" >&2; return 1; }
}
export -f compile
export flags
find core store scene renderers metrics studies reports bench -name '*.h' -print0 |
  xargs -0 -r -n 1 -P "$(nproc)" bash -c 'compile "$0"'
echo "check_headers: every header compiles alone"
