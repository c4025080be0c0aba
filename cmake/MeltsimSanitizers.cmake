# SPDX-License-Identifier: Apache-2.0
# Sanitizers go to every target of this project: half a program with AddressSanitizer reports nonsense.
if(MELTSIM_SANITIZE)
  string(REPLACE ";" "," sanitizers "${MELTSIM_SANITIZE}")
  add_compile_options("$<$<COMPILE_LANGUAGE:CXX>:-fsanitize=${sanitizers};-fno-omit-frame-pointer;-g>")
  add_link_options(-fsanitize=${sanitizers})
  if(NOT "thread" IN_LIST MELTSIM_SANITIZE)
    add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-fno-sanitize-recover=all>)
  endif()
  if("thread" IN_LIST MELTSIM_SANITIZE)
    # An OpenMP barrier orders memory, but only clang's libomp can say so to ThreadSanitizer, through its tool
    # Archer. libomp loads it by name at start, so its directory goes into the programs' run path (the old kind,
    # which libraries inherit).
    if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
      execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-resource-dir
        OUTPUT_VARIABLE clang_resources OUTPUT_STRIP_TRAILING_WHITESPACE)  # <llvm>/lib/clang/<version>
      get_filename_component(llvm_libraries ${clang_resources}/../.. REALPATH)
      find_library(MELTSIM_ARCHER archer HINTS ${llvm_libraries})
      mark_as_advanced(MELTSIM_ARCHER)
    endif()
    if(MELTSIM_ARCHER)
      get_filename_component(archer_directory ${MELTSIM_ARCHER} DIRECTORY)
      add_link_options(-Wl,--disable-new-dtags -Wl,-rpath,${archer_directory})
    else()
      message(WARNING "MELTSIM_SANITIZE=thread without clang++ and its Archer tool reports false races at every "
                      "OpenMP barrier. Fix: the tsan preset; Debian/Ubuntu: apt install clang libomp-dev")
    endif()
  endif()
endif()
