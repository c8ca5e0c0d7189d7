# crowdbench_library(name DEPENDS ...): one folder is one static library of the same name, `crowdbench::name`.
# Sources are globbed, so that a new file (or a new representation's folder) needs no edit here. Files under a
# `module/` folder belong to a module that is loaded at first use and are left out. They use the plain precompiled
# headers (PrecompiledHeaders.cmake).
add_library(crowdbench_flags INTERFACE)
target_compile_options(crowdbench_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wno-missing-field-initializers
  # The crowd's bytes must not depend on the compiler's choice to fuse a multiply and an add.
  -ffp-contract=off
  $<$<BOOL:${CROWDBENCH_WERROR}>:-Werror>)
if(CROWDBENCH_SANITIZE)
  target_compile_options(crowdbench_flags INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=all
                         -fno-omit-frame-pointer
                         # GCC 12 sees uninitialised members in the standard library's <regex> when it instruments.
                         $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>
                         # In what only tests (targets with the property CROWDBENCH_TEST), without the checks of every
                         # pointer: a third of its compilation, and nearly half of all that is compiled. ASan stops at
                         # bad pointers there too; what is tested has all checks.
                         $<$<BOOL:$<TARGET_PROPERTY:CROWDBENCH_TEST>>:-fno-sanitize=null,alignment,vptr,object-size>)
  target_link_options(crowdbench_flags INTERFACE -fsanitize=address,undefined -Wl,--export-dynamic-symbol=dlclose
                      -Wl,--export-dynamic-symbol=__asan_default_options)
  target_sources(crowdbench_flags INTERFACE ${PROJECT_SOURCE_DIR}/cmake/sanitizer_runtime.cpp)
endif()
if(CROWDBENCH_FUZZ)
  target_compile_options(crowdbench_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()
target_compile_definitions(crowdbench_flags INTERFACE GLM_FORCE_DEPTH_ZERO_TO_ONE GLM_FORCE_CTOR_INIT)
target_include_directories(crowdbench_flags INTERFACE ${PROJECT_SOURCE_DIR})

function(crowdbench_library name)
  cmake_parse_arguments(ARG "" "" "DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "/module/|/main\\.cpp$")
  if(NOT sources)
    file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/empty.cpp "")
    set(sources ${CMAKE_CURRENT_BINARY_DIR}/empty.cpp)
  endif()
  add_library(crowdbench_${name} STATIC ${sources})
  add_library(crowdbench::${name} ALIAS crowdbench_${name})
  target_link_libraries(crowdbench_${name} PUBLIC crowdbench_flags ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE_DEPENDS})
  crowdbench_precompile(crowdbench_${name} plain)
endfunction()

# crowdbench_light_optimisation(FILES ...): sources of the calling folder that parse, print or talk to a driver. Where nothing
# is computed, light optimisation halves the time to compile.
function(crowdbench_light_optimisation)
  set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS $<$<CONFIG:Release>:-O1>)
endfunction()

# crowdbench_module(name SOURCES ... DEPENDS ...): a shared object with a C entry point, loaded by core/module.h at first
# use, so that heavy libraries cost nothing at start-up and may be absent from a bundle.
function(crowdbench_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_library(crowdbench_${name} MODULE ${ARG_SOURCES})
  set_target_properties(crowdbench_${name} PROPERTIES PREFIX "" CXX_VISIBILITY_PRESET hidden)
  target_link_libraries(crowdbench_${name} PRIVATE crowdbench_flags ${ARG_DEPENDS})
endfunction()
