#!/usr/bin/env bash
# Every variant of every program passes glslangValidator. Usage: check_shaders.sh BUILD_DIR [FILE...]
# FILES: these texts instead, as CROWDBENCH_DUMP_SHADERS keeps them; no build is needed for that.
set -euo pipefail
build=${1:-build/release}
[ $# -eq 0 ] || shift
command -v glslangValidator >/dev/null || { echo "check_shaders: glslangValidator is missing (glslang-tools)" >&2; exit 2; }
if [ $# -gt 0 ]; then
  said=$(glslangValidator "$@") || { echo "$said" >&2; exit 1; }
  echo "check_shaders: $# shader texts given to glslangValidator"
  exit
fi
[ -x "$build/bin/test_renderers" ] || { echo "check_shaders: no $build/bin/test_renderers; build first" >&2; exit 2; }
said=$("$build/bin/test_renderers" --gtest_filter='ShaderVariantsGl.*') || { echo "$said" >&2; exit 1; }
echo "check_shaders: $(grep -o '[0-9]* shader texts of .*' <<<"$said")"
