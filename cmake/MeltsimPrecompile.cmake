# SPDX-License-Identifier: Apache-2.0
# Half of what most files of programs and tests take to compile is the same few headers. CMAKE_DISABLE_PRECOMPILE_HEADERS=ON
# reads them anew in every file, as a check that each file includes what it uses.

# meltsim_precompile(<target> <header>...): reads the headers once for all files of the target. List
# ours first: it must not need what others happen to include.
function(meltsim_precompile name)
  set(headers)
  foreach(header IN LISTS ARGN)
    list(APPEND headers "$<$<COMPILE_LANGUAGE:CXX>:${header}$<ANGLE-R>>")
  endforeach()
  target_precompile_headers(${name} PRIVATE ${headers})
endfunction()

# meltsim_compile_quickly(<target> <header>...): likewise, and without optimisation, for programs whose time is spent in the
# library.
function(meltsim_compile_quickly name)
  target_compile_options(${name} PRIVATE $<$<AND:$<CONFIG:Release>,$<COMPILE_LANGUAGE:CXX>>:-O0>)
  meltsim_precompile(${name} ${ARGN})
endfunction()

# meltsim_compile_together(<target> [<file>...]): compiles the target's files eight at a time, for two fifths of the time go into the
# same headers and templates again and again; each <file> by itself. CMAKE_UNITY_BUILD=OFF compiles all by themselves, as a
# check that each file includes what it uses.
function(meltsim_compile_together name)
  if(DEFINED CMAKE_UNITY_BUILD AND NOT CMAKE_UNITY_BUILD)
    return()
  endif()
  set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
  if(ARGN)
    set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
endfunction()
