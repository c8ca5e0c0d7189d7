# crowdbench_precompile(TARGET KIND): headers of the standard library and of other projects that TARGET's sources need not
# parse again. Two thirds of a compilation without them is parsing. Only speed: every source includes what it uses and
# compiles without (-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON). No header of this project is among them, or an edit would
# compile everything again.
#
# KIND: plain (standard library, fmt, glm) or test (plain and GoogleTest). One a build, compiled once by an otherwise empty
# library and used by all of its kind. A header that few sources use has no place here: whatever its inline functions
# instantiate is instantiated again in every source, used or not (nlohmann-json: 0.7 s each).
set(crowdbench_headers_plain
  <algorithm> <array> <cassert> <charconv> <cmath> <cstdint> <cstring> <filesystem> <fstream> <functional> <limits> <map>
  <memory> <numbers> <numeric> <optional> <set> <span> <string> <string_view> <tuple> <utility> <variant> <vector>
  <fmt/format.h> <glm/glm.hpp> <glm/gtc/quaternion.hpp>)
set(crowdbench_headers_test ${crowdbench_headers_plain} <gtest/gtest.h>)

# Clang accepts another target's only where every definition is the same.
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
endif()

set(crowdbench_precompiled_options)
if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
  set(crowdbench_precompiled_options
    # A compiler cache sees by it which precompiled header was used.
    $<$<COMPILE_LANGUAGE:CXX>:-fpch-preprocess>
    # Out of a precompiled header GCC 12 forgets that <string> is a system header, and its false alarms on inlined strings
    # (its bug 105651) come through.
    $<$<COMPILE_LANGUAGE:CXX>:-Wno-array-bounds>
    $<$<COMPILE_LANGUAGE:CXX>:-Wno-restrict>
    $<$<COMPILE_LANGUAGE:CXX>:-Wno-stringop-overflow>
    $<$<COMPILE_LANGUAGE:CXX>:-Wno-stringop-overread>)
endif()

function(crowdbench_precompile target kind)
  set(owner crowdbench_headers_${kind})
  if(NOT TARGET ${owner})
    file(WRITE ${CMAKE_BINARY_DIR}/${owner}.cpp "")
    add_library(${owner} OBJECT ${CMAKE_BINARY_DIR}/${owner}.cpp)
    target_link_libraries(${owner} PRIVATE crowdbench_flags fmt::fmt glm::glm)
    if(kind STREQUAL "test")
      target_link_libraries(${owner} PRIVATE GTest::gtest)
      target_compile_options(${owner} PRIVATE -fPIE)  # tests are programs, and position-independent as such
      set_target_properties(${owner} PROPERTIES CROWDBENCH_TEST ON)
    endif()
    target_precompile_headers(${owner} PRIVATE ${crowdbench_headers_${kind}})
    target_compile_options(${owner} PRIVATE ${crowdbench_precompiled_options})
  endif()
  target_precompile_headers(${target} REUSE_FROM ${owner})
  target_compile_options(${target} PRIVATE ${crowdbench_precompiled_options})
endfunction()
