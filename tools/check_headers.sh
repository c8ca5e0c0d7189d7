#!/usr/bin/env bash
# Fails when a header does not compile alone. Usage: check_headers.sh BUILD_DIR [HEADER...]
# BUILD_DIR: a configured build, for its include paths. Without HEADERs every one of the product.
# What many headers include of the standard library, and glm, comes from a precompiled header, which takes a fifth of the
# time; that a header includes what it names of it is for tests/core/includes_test.cpp to say.
set -euo pipefail
top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
commands=$(realpath -m "${1:-$top/build/release}")/compile_commands.json
[ $# -eq 0 ] || shift
[ -f "$commands" ] || { echo "check_headers: no $commands; configure first" >&2; exit 2; }

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
# Every include path and definition that any target uses, once.
flags=$(grep -o '"command": ".*\.cpp"' "$commands" | grep -oE '(-isystem [^ ]+|-I[^ ]+|-DGLM[^ ]+|-DFMT[^ ]+)' | sort -u | tr '\n' ' ')
flags="-std=c++20 -Wall -Wextra -Wno-missing-field-initializers $flags -I."
compile() {
  local header=$1
  printf '#include "%s"\n' "$header" | g++ -include "$scratch/common.h" -fsyntax-only $flags -x c++ - ||
    { echo "check_headers: $header does not compile alone" >&2; return 1; }
}
export -f compile
export flags scratch
mapfile -t headers < <([ $# -eq 0 ] || realpath -m "$@")
cd "$top"
[ ${#headers[@]} -gt 0 ] ||
  mapfile -t headers < <(find core store scene truth renderers metrics studies reports bench -name '*.h')
# What at least ten headers include.
printf '#include <%s>\n' array cstddef cstdint filesystem functional glm/glm.hpp map memory optional set span string string_view \
  utility variant vector >"$scratch/common.h"
g++ $flags -x c++-header "$scratch/common.h" -o "$scratch/common.h.gch"
printf '%s\0' "${headers[@]}" | xargs -0 -n 1 -P "$(nproc)" bash -c 'compile "$0"'
echo "check_headers: every header compiles alone"
