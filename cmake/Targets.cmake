# crowdbench_library(name DEPENDS ...): one folder is one static library of the same name, `crowdbench::name`.
# Sources are globbed, so that a new file (or a new representation's folder) needs no edit here. Files under a
# `module/` folder belong to a module that is loaded at first use and are left out, and so are those of a folder below
# that has a CMakeLists.txt, which is a library of its own. They use the plain precompiled headers
# (PrecompiledHeaders.cmake).
add_library(crowdbench_flags INTERFACE)
target_compile_options(crowdbench_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wno-missing-field-initializers
  # The crowd's bytes must not depend on the compiler's choice to fuse a multiply and an add.
  -ffp-contract=off
  $<$<BOOL:${CROWDBENCH_WERROR}>:-Werror>)
if(CROWDBENCH_SANITIZE)
  target_compile_options(crowdbench_flags INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=all
                         -fno-omit-frame-pointer
                         # What only tests (targets with the property CROWDBENCH_TEST) is nearly half of all that is compiled,
                         # and takes half the time without optimisation and without the checks of every pointer. ASan stops
                         # at bad pointers there too; what is tested has all checks.
                         $<$<BOOL:$<TARGET_PROPERTY:CROWDBENCH_TEST>>:-O0>
                         $<$<BOOL:$<TARGET_PROPERTY:CROWDBENCH_TEST>>:-fno-sanitize=null,alignment,vptr,object-size>)
  target_link_options(crowdbench_flags INTERFACE -fsanitize=address,undefined -Wl,--export-dynamic-symbol=dlclose
                      -Wl,--export-dynamic-symbol=__asan_default_options)
  target_sources(crowdbench_flags INTERFACE ${PROJECT_SOURCE_DIR}/cmake/sanitizer_runtime.cpp)
endif()
set(CROWDBENCH_FUZZ OFF)
if(CROWDBENCH_SANITIZE AND CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  set(CROWDBENCH_FUZZ ON)
endif()
target_compile_definitions(crowdbench_flags INTERFACE GLM_FORCE_DEPTH_ZERO_TO_ONE GLM_FORCE_CTOR_INIT)
target_include_directories(crowdbench_flags INTERFACE ${PROJECT_SOURCE_DIR})

# LIGHT and ALONE are regular expressions over paths below the folder. LIGHT: sources that parse, print or talk to a driver;
# where nothing is computed, light optimisation halves the time to compile. ALONE: sources that are compiled by themselves,
# because they are long, or have properties of their own.
#
# The rest is compiled up to CROWDBENCH_TOGETHER neighbours in a folder at a time: what they parse and instantiate alike they do
# once. Every source compiles by itself as well: the preset `debug` does so.
#
# FUZZED, of the same kind: sources with parsers, whose branches the fuzzer is to see.
function(crowdbench_library name)
  cmake_parse_arguments(ARG "" "LIGHT;ALONE;FUZZED" "DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "(^|/)module/|(^|/)main\\.cpp$")
  file(GLOB libraries RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR}/*/CMakeLists.txt)
  foreach(library IN LISTS libraries)
    cmake_path(GET library PARENT_PATH folder)
    list(FILTER sources EXCLUDE REGEX "^${folder}/")
  endforeach()
  list(SORT sources)
  crowdbench_compile_together(compiled "${ARG_LIGHT}" "${ARG_ALONE}" "${ARG_FUZZED}" ${sources})
  add_library(crowdbench_${name} STATIC ${compiled})
  add_library(crowdbench::${name} ALIAS crowdbench_${name})
  target_link_libraries(crowdbench_${name} PUBLIC crowdbench_flags ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE_DEPENDS})
  crowdbench_precompile(crowdbench_${name} plain)
endfunction()

# crowdbench_compile_together(OUT LIGHT ALONE FUZZED SOURCES...): OUT is what to compile for the SOURCES, paths below the calling
# folder; some are files in the build tree that include several of them.
function(crowdbench_compile_together out light alone fuzzed)
  set(groups)
  foreach(source IN LISTS ARGN)
    cmake_path(GET source PARENT_PATH group)
    if(light AND source MATCHES "${light}")
      string(APPEND group "_light")
    endif()
    if(CROWDBENCH_FUZZ AND fuzzed AND source MATCHES "${fuzzed}")
      string(APPEND group "_fuzzed")
    endif()
    if(CROWDBENCH_TOGETHER EQUAL 1 OR (alone AND source MATCHES "${alone}"))
      string(PREPEND group "${source} ")
    endif()
    list(APPEND groups "sources_${group}")
    list(APPEND "sources_${group}" ${source})
  endforeach()
  list(REMOVE_DUPLICATES groups)
  set(compiled)
  foreach(group IN LISTS groups)
    list(LENGTH "${group}" count)
    math(EXPR last "${count} - 1")
    foreach(from RANGE 0 ${last} ${CROWDBENCH_TOGETHER})
      list(SUBLIST "${group}" ${from} ${CROWDBENCH_TOGETHER} members)
      crowdbench_one_to_compile(file "${group}_${from}" ${members})
      if(group MATCHES "_light")
        set_property(SOURCE ${file} APPEND PROPERTY COMPILE_OPTIONS $<$<CONFIG:Release>:-O1>)
      endif()
      if(group MATCHES "_fuzzed$")
        set_property(SOURCE ${file} APPEND PROPERTY COMPILE_OPTIONS -fsanitize=fuzzer-no-link)
        set_property(SOURCE ${file} PROPERTY SKIP_PRECOMPILE_HEADERS ON)  # made without that
      endif()
      list(APPEND compiled ${file})
    endforeach()
  endforeach()
  set(${out} ${compiled} PARENT_SCOPE)
endfunction()

# crowdbench_one_to_compile(OUT NAME SOURCES...): OUT is the one source, or a file in the build tree that includes them.
function(crowdbench_one_to_compile out name)
  set(file ${ARGN})
  list(LENGTH ARGN count)
  if(count GREATER 1)
    string(MAKE_C_IDENTIFIER "${name}" name)
    list(TRANSFORM ARGN REPLACE "(.+)" "#include \"${CMAKE_CURRENT_SOURCE_DIR}/\\1\"\n" OUTPUT_VARIABLE includes)
    string(JOIN "" content ${includes})
    set(file ${CMAKE_CURRENT_BINARY_DIR}/together/${name}.cpp)
    file(CONFIGURE OUTPUT ${file} CONTENT "${content}" @ONLY)
    # A type with members of an unnamed namespace is the rule in a source, and GCC takes only the outermost file for one.
    set_property(SOURCE ${file} PROPERTY COMPILE_OPTIONS $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
  endif()
  set(${out} ${file} PARENT_SCOPE)
endfunction()

# crowdbench_module(name SOURCES ... DEPENDS ...): a shared object with a C entry point, loaded by core/module.h at first
# use, so that heavy libraries cost nothing at start-up and may be absent from a bundle.
function(crowdbench_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  crowdbench_compile_together(compiled "" "" "" ${ARG_SOURCES})
  add_library(crowdbench_${name} MODULE ${compiled})
  set_target_properties(crowdbench_${name} PROPERTIES PREFIX "" CXX_VISIBILITY_PRESET hidden)
  target_link_libraries(crowdbench_${name} PRIVATE crowdbench_flags ${ARG_DEPENDS})
endfunction()
