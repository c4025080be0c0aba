# SPDX-License-Identifier: Apache-2.0
include(GoogleTest)
include(MeltsimPrecompile)

# meltsim_add_test(<name> SOURCES <files> [PUBLIC] [LABELS <label>] [LIBRARIES <targets>] [TIMEOUT <s>])
#
# One GoogleTest program. It links the archive with the library's internals (include paths src/ and cuda/), or
# with PUBLIC only what hosts get. Label `gpu`: its tests need a GPU and must call GTEST_SKIP() without one,
# which CTest then reports as skipped. Every test case becomes one CTest test, "<name>.<suite>.<case>".
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
  if(arg_PUBLIC)
    target_link_libraries(${name} PRIVATE meltsim::meltsim meltsim_floating_point)
  else()
    target_link_libraries(${name} PRIVATE meltsim_internal)
  endif()
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)  # for "support/..."
  target_link_libraries(${name} PRIVATE meltsim_warnings GTest::gtest GTest::gtest_main ${arg_LIBRARIES})
  if(arg_PUBLIC)
    meltsim_compile_quickly(${name} <gtest/gtest.h> <meltsim/meltsim.hpp>)
  else()
    # Formulas are inline: without optimisation the tests themselves take minutes.
    target_compile_options(${name} PRIVATE $<$<AND:$<CONFIG:Release>,$<COMPILE_LANGUAGE:CXX>>:-O1>)
    meltsim_precompile(${name} <gtest/gtest.h>)
  endif()
  # Found when CTest runs, not when the program is built: a build machine need not be able to run it.
  gtest_discover_tests(${name} TEST_PREFIX ${name}. DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60
    PROPERTIES TIMEOUT ${arg_TIMEOUT} ${labels})
endfunction()
