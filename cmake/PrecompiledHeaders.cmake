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

# GCC's bring its false alarms on inlined strings with them (its bug 105651), and its flags are none of Clang's, which lints what
# the presets compile.
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  set(CMAKE_DISABLE_PRECOMPILE_HEADERS ON)
endif()
function(crowdbench_precompile target kind)
  set(owner crowdbench_headers_${kind})
  if(NOT TARGET ${owner})
    file(WRITE ${CMAKE_BINARY_DIR}/${owner}.cpp "")
    add_library(${owner} OBJECT ${CMAKE_BINARY_DIR}/${owner}.cpp)
    target_link_libraries(${owner} PRIVATE crowdbench_flags fmt::fmt glm::glm)
    if(kind STREQUAL "test")
      target_link_libraries(${owner} PRIVATE GTest::gtest)
      # Tests are programs, and position-independent as such; for their optimisation see tests/CMakeLists.txt.
      target_compile_options(${owner} PRIVATE -fPIE $<$<CONFIG:Release>:-O0>)
      set_target_properties(${owner} PROPERTIES CROWDBENCH_TEST ON)
    endif()
    target_precompile_headers(${owner} PRIVATE ${crowdbench_headers_${kind}})
    # Without a time in it, so that a compiler cache knows it again.
    target_compile_options(${owner} PRIVATE "$<$<COMPILE_LANG_AND_ID:CXX,Clang>:SHELL:-Xclang -fno-pch-timestamp>")
  endif()
  target_precompile_headers(${target} REUSE_FROM ${owner})
endfunction()
