# SPDX-License-Identifier: Apache-2.0
include(GoogleTest)
include(MeltsimPrecompile)

# What a text of a test sees and how it is compiled: the archive with the library's internals (include paths src/ and cuda/), or
# with PUBLIC only what hosts get. One target per kind precompiles the headers for all others.
function(meltsim_text_options name public)
  set(kind internal)
  set(headers <gtest/gtest.h>)
  if(public)
    set(kind public)
    list(PREPEND headers <meltsim/meltsim.hpp>)
    target_link_libraries(${name} PRIVATE meltsim::meltsim meltsim_floating_point)
    target_compile_options(${name} PRIVATE $<$<AND:$<CONFIG:Release>,$<COMPILE_LANGUAGE:CXX>>:-O0>)
  else()
    target_link_libraries(${name} PRIVATE meltsim_internal)
    # Formulas are inline: without optimisation the tests themselves take minutes.
    target_compile_options(${name} PRIVATE $<$<AND:$<CONFIG:Release>,$<COMPILE_LANGUAGE:CXX>>:-O1>)
  endif()
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)  # for "support/..."
  target_link_libraries(${name} PRIVATE meltsim_warnings GTest::gtest)
  set(owner meltsim_test_headers_${kind})
  if(name STREQUAL owner)
    meltsim_precompile(${name} ${headers})
    return()
  endif()
  if(NOT TARGET ${owner})
    file(GENERATE OUTPUT ${PROJECT_BINARY_DIR}/tests/${owner}.cpp CONTENT "")
    add_library(${owner} OBJECT EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/tests/${owner}.cpp)
    meltsim_text_options(${owner} ${public})
  endif()
  target_precompile_headers(${name} REUSE_FROM ${owner})
endfunction()

# meltsim_add_texts(<name> <files>): texts for several programs with PUBLIC, compiled once. Nothing in them depends on the backends
# of the build: a compiler cache has for one with CUDA what one without has compiled.
function(meltsim_add_texts name)
  add_library(${name} OBJECT EXCLUDE_FROM_ALL ${ARGN})
  meltsim_text_options(${name} TRUE)
endfunction()

# meltsim_add_test(<name> SOURCES <files> [PUBLIC] [LABELS <label>] [LIBRARIES <targets>] [TIMEOUT <s>])
#
# One GoogleTest program; LIBRARIES may be what meltsim_add_texts made. Label `gpu`: its tests need a GPU and must call
# GTEST_SKIP() without one, which CTest then reports as skipped. Every test case becomes one CTest test,
# "<name>.<suite>.<case>".
function(meltsim_add_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "PUBLIC" "TIMEOUT;LABELS" "SOURCES;LIBRARIES")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "meltsim_add_test(${name}): ${arg_UNPARSED_ARGUMENTS}? LABELS takes one label")
  endif()
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 300)
  endif()
  set(labels)
  if(arg_LABELS)
    set(labels LABELS ${arg_LABELS})
  endif()
  add_executable(${name} ${arg_SOURCES})
  meltsim_text_options(${name} ${arg_PUBLIC})
  target_link_libraries(${name} PRIVATE GTest::gtest_main ${arg_LIBRARIES})
  # Found when CTest runs, not when the program is built: a build machine need not be able to run it.
  gtest_discover_tests(${name} TEST_PREFIX ${name}. DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60
    PROPERTIES TIMEOUT ${arg_TIMEOUT} ${labels})
endfunction()
