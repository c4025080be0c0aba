# SPDX-License-Identifier: Apache-2.0
# Sanitizers go to every target of this project: half a program with AddressSanitizer reports nonsense.
if(MELTSIM_SANITIZE)
  string(REPLACE ";" "," sanitizers "${MELTSIM_SANITIZE}")
  add_compile_options("$<$<COMPILE_LANGUAGE:CXX>:-fsanitize=${sanitizers};-fno-omit-frame-pointer;-g>")
  add_link_options(-fsanitize=${sanitizers})
  if(NOT "thread" IN_LIST MELTSIM_SANITIZE)
    add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-fno-sanitize-recover=all>)
  endif()
endif()
