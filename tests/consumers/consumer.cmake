# SPDX-License-Identifier: Apache-2.0
# Builds and runs the host program in one of several ways, with everything CUDA taken out of the environment.
#   cmake -D MODE=... -D WORK=<dir> ... -P consumer.cmake
# MODE install           installs BUILD (configuration CONFIG) into PREFIX
#      find_package      finds it in PREFIX
#      pkg_config        the same with pkg-config and a bare compiler; STATIC adds --static
#      partial_install   installs SUBPROJECT of which one program is built and one is not
#      add_subdirectory  builds SOURCE within the host's tree, static
cmake_minimum_required(VERSION 3.22)

function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE result)
  if(result)
    list(JOIN ARGV " " text)
    message(FATAL_ERROR "failed (${result}): ${text}")
  endif()
endfunction()

# Directories with an nvcc leave PATH; the variables that point to a toolkit are unset.
function(hide_cuda)
  string(REPLACE ":" ";" path "$ENV{PATH}")
  set(kept)
  foreach(directory IN LISTS path)
    if(NOT EXISTS ${directory}/nvcc)
      list(APPEND kept ${directory})
    endif()
  endforeach()
  list(JOIN kept ":" kept)
  set(ENV{PATH} "${kept}")
  foreach(variable CUDACXX CUDA_HOME CUDA_PATH CUDA_ROOT CUDAToolkit_ROOT LIBRARY_PATH CPATH CPLUS_INCLUDE_PATH
                   LD_LIBRARY_PATH)
    unset(ENV{${variable}})
  endforeach()
endfunction()

function(expect_no_cuda build)
  if(EXISTS ${build}/CMakeCache.txt)
    file(STRINGS ${build}/CMakeCache.txt found REGEX "^(CMAKE_CUDA_COMPILER|CUDAToolkit_BIN_DIR|CUDA_.*):.*=/")
    if(found)
      message(FATAL_ERROR "the host's configure looked for CUDA: ${found}")
    endif()
  endif()
  execute_process(COMMAND readelf -d ${build}/host OUTPUT_VARIABLE dynamic COMMAND_ERROR_IS_FATAL ANY)
  if(dynamic MATCHES "libcu[a-z]+")
    message(FATAL_ERROR "the host needs CUDA at run time:\n${dynamic}")
  endif()
endfunction()

set(configure_options -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}
    -DCMAKE_DISABLE_FIND_PACKAGE_CUDAToolkit=ON -DCMAKE_DISABLE_FIND_PACKAGE_CUDA=ON)

hide_cuda()
if(MODE STREQUAL "install")
  file(REMOVE_RECURSE ${PREFIX})
  run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX} --config ${CONFIG})

elseif(MODE STREQUAL "find_package")
  file(REMOVE_RECURSE ${WORK})
  run(${CMAKE_COMMAND} -S ${HOST} -B ${WORK} ${configure_options} -DCMAKE_PREFIX_PATH=${PREFIX})
  run(${CMAKE_COMMAND} --build ${WORK})
  expect_no_cuda(${WORK})
  run(${WORK}/host)

elseif(MODE STREQUAL "pkg_config")
  file(REMOVE_RECURSE ${WORK})
  file(MAKE_DIRECTORY ${WORK})
  set(ENV{PKG_CONFIG_PATH} ${PREFIX}/${LIBDIR}/pkgconfig)
  set(static)
  if(STATIC)
    set(static --static)
  endif()
  execute_process(COMMAND pkg-config ${static} --cflags --libs meltsim
    OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  message(STATUS "pkg-config: ${flags}")
  separate_arguments(flags UNIX_COMMAND "${flags}")
  run(${CXX} -std=c++17 -O1 ${HOST}/main.cpp -o ${WORK}/host ${flags} -Wl,-rpath,${PREFIX}/${LIBDIR})
  expect_no_cuda(${WORK})
  run(${WORK}/host)

elseif(MODE STREQUAL "add_subdirectory")
  # Kept between runs: it is the only test that compiles the library again. Nothing is optimised, because the host computes for
  # an instant.
  run(${CMAKE_COMMAND} -S ${SUBPROJECT} -B ${WORK} ${configure_options} -DMELTSIM_SOURCE_DIR=${SOURCE}
      -DMELTSIM_CCACHE=OFF "-DCMAKE_CXX_FLAGS_RELEASE=-O0 -DMELTSIM_ONE_WIDTH" -DMELTSIM_WARNINGS_AS_ERRORS=${AS_ERRORS})
  run(${CMAKE_COMMAND} --build ${WORK} --parallel ${JOBS})
  expect_no_cuda(${WORK})
  run(${WORK}/host)
  execute_process(COMMAND nm -D --defined-only ${WORK}/libplugin.so OUTPUT_VARIABLE exported COMMAND_ERROR_IS_FATAL ANY)
  if(NOT exported MATCHES " plugin_version" OR exported MATCHES " (meltsim_|_ZNK?7meltsim|_ZT[IVS]N7meltsim)")
    message(FATAL_ERROR "a library with meltsim inside is to export nothing of it:\n${exported}")
  endif()
  # Without a word of the host's it is a shared library, and the host's own libraries are what they were.
  file(WRITE ${WORK}/parent/CMakeLists.txt "cmake_minimum_required(VERSION 3.22)
project(parent LANGUAGES CXX)
set(MELTSIM_CUDA OFF)
add_subdirectory(${SOURCE} meltsim)
file(WRITE \${CMAKE_BINARY_DIR}/own.cpp \"int own() { return 0; }\")
add_library(own \${CMAKE_BINARY_DIR}/own.cpp)
get_target_property(own_type own TYPE)
get_target_property(type meltsim TYPE)
if(NOT own_type STREQUAL STATIC_LIBRARY OR NOT type STREQUAL SHARED_LIBRARY)
  message(FATAL_ERROR \"the host's library is a \${own_type}, meltsim a \${type}\")
endif()
")
  run(${CMAKE_COMMAND} -S ${WORK}/parent -B ${WORK}/parent/build ${configure_options})

elseif(MODE STREQUAL "partial_install")
  file(REMOVE_RECURSE ${WORK} ${PREFIX})
  run(${CMAKE_COMMAND} -S ${SUBPROJECT} -B ${WORK} ${configure_options} -DMODULE=${SOURCE}/cmake/MeltsimInstallProgram.cmake)
  run(${CMAKE_COMMAND} --build ${WORK} --target built)
  execute_process(COMMAND ${CMAKE_COMMAND} --install ${WORK} --prefix ${PREFIX} --config Release
    OUTPUT_VARIABLE said COMMAND_ERROR_IS_FATAL ANY)
  if(NOT EXISTS ${PREFIX}/bin/built OR EXISTS ${PREFIX}/bin/unbuilt)
    message(FATAL_ERROR "what is built is to be installed, and nothing else:\n${said}")
  endif()
  if(NOT said MATCHES "not built: unbuilt [^\n]*--target unbuilt" OR said MATCHES "not built: built")
    message(FATAL_ERROR "the program that is left out is to be named, with the command that builds it:\n${said}")
  endif()

else()
  message(FATAL_ERROR "unknown MODE \"${MODE}\"")
endif()
