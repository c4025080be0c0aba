# SPDX-License-Identifier: Apache-2.0
# Sanitizers go to every target of this project: half a program with AddressSanitizer reports nonsense.
# -g1: a report names functions and lines, and units compile in two thirds of the time that -g takes.
if(MELTSIM_SANITIZE)
  string(REPLACE ";" "," sanitizers "${MELTSIM_SANITIZE}")
  add_compile_options("$<$<COMPILE_LANGUAGE:CXX>:-fsanitize=${sanitizers};-fno-omit-frame-pointer;-g1>")
  add_link_options(-fsanitize=${sanitizers})
  add_compile_definitions(MELTSIM_ONE_WIDTH)  # src/exec/wide.hpp
  if(NOT "thread" IN_LIST MELTSIM_SANITIZE)
    add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-fno-sanitize-recover=all>)
  endif()
endif()
