#!/usr/bin/env bash
# Every variant of every program passes glslangValidator. Usage: check_shaders.sh BUILD_DIR
set -euo pipefail
build=${1:-build/release}
command -v glslangValidator >/dev/null || { echo "check_shaders: glslangValidator is missing (glslang-tools)" >&2; exit 2; }
[ -x "$build/bin/test_renderers" ] || { echo "check_shaders: no $build/bin/test_renderers; build first" >&2; exit 2; }
said=$("$build/bin/test_renderers" --gtest_filter='ShaderVariantsGl.*') || { echo "$said" >&2; exit 1; }
echo "check_shaders: $(grep -o '[0-9]* shader texts of .*' <<<"$said")"
