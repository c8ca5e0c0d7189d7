#!/usr/bin/env bash
# Fails when a header does not compile alone. Usage: check_headers.sh BUILD_DIR [HEADER...]
# BUILD_DIR: a configured build, for its include paths. Without HEADERs every one of the product.
set -euo pipefail
top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
commands=$(realpath -m "${1:-$top/build/release}")/compile_commands.json
[ $# -eq 0 ] || shift
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
if [ $# -gt 0 ]; then
  mapfile -t headers < <(realpath -m "$@")
  cd "$top"
  printf '%s\0' "${headers[@]}" | xargs -0 -n 1 -P "$(nproc)" bash -c 'compile "$0"'
  exit
fi
cd "$top"
find core store scene truth renderers metrics studies reports bench -name '*.h' -print0 |
  xargs -0 -r -n 1 -P "$(nproc)" bash -c 'compile "$0"'
echo "check_headers: every header compiles alone"
