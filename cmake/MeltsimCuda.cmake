# SPDX-License-Identifier: Apache-2.0
# Decides whether the CUDA backend is built and says why.
# Sets MELTSIM_HAVE_CUDA, MELTSIM_CUDA_REASON; makes target meltsim_cuda_options.

set(MELTSIM_HAVE_CUDA OFF)
set(MELTSIM_CUDA_REASON "MELTSIM_CUDA=OFF")

if(NOT MELTSIM_CUDA MATCHES "^(AUTO|ON|OFF|TRUE|FALSE|YES|NO|1|0)$")
  message(FATAL_ERROR "MELTSIM_CUDA is \"${MELTSIM_CUDA}\"; use AUTO, ON or OFF")
endif()

set(cuda_wanted ${MELTSIM_CUDA})
if(MELTSIM_CUDA STREQUAL "AUTO")
  set(cuda_wanted ON)
endif()

if(cuda_wanted)
  if(DEFINED CACHE{CMAKE_CUDA_COMPILER} AND NOT CMAKE_CUDA_COMPILER)
    unset(CMAKE_CUDA_COMPILER CACHE)  # a toolkit may have been installed since the last configure
  endif()
  include(CheckLanguage)
  check_language(CUDA)
  if(CMAKE_CUDA_COMPILER)
    set(MELTSIM_HAVE_CUDA ON)
    set(MELTSIM_CUDA_REASON "${CMAKE_CUDA_COMPILER}")
  else()
    find_program(MELTSIM_NVCC nvcc HINTS /usr/local/cuda/bin)
    mark_as_advanced(MELTSIM_NVCC)
    if(MELTSIM_NVCC)
      set(MELTSIM_CUDA_REASON
          "${MELTSIM_NVCC} exists but is not in PATH, or it rejects the host compiler. Fix: export \
CUDACXX=${MELTSIM_NVCC}, and if that is not enough CUDAHOSTCXX=<an older g++>")
    else()
      set(MELTSIM_CUDA_REASON "no nvcc in PATH or CUDACXX")
    endif()
    if(NOT MELTSIM_CUDA STREQUAL "AUTO")
      message(FATAL_ERROR "MELTSIM_CUDA=ON, but: ${MELTSIM_CUDA_REASON}")
    endif()
  endif()
endif()

if(MELTSIM_HAVE_CUDA)
  # CMake's own default is the oldest architecture the toolkit knows, whose code a new GPU translates at every
  # first start. 90 is what this project is measured on; the PTX that comes with it runs on anything newer.
  # Others: 75 Turing, 80 A100, 86 RTX 30, 89 RTX 40, 90 H100/H200, 100 B200, 120 RTX 50. Lists are fine:
  # -DCMAKE_CUDA_ARCHITECTURES="80;90". `native` asks the GPU of this machine.
  if(NOT DEFINED CMAKE_CUDA_ARCHITECTURES)
    set(CMAKE_CUDA_ARCHITECTURES 90 CACHE STRING "CUDA architectures, e.g. 75;80;86;89;90;100;120")
  endif()

  # Checked before the language is enabled, where a wrong one would only say "compiler identification failed".
  if("native" IN_LIST CMAKE_CUDA_ARCHITECTURES)
    execute_process(COMMAND nvidia-smi -L RESULT_VARIABLE no_gpu OUTPUT_VARIABLE gpus ERROR_QUIET)
    if(no_gpu OR NOT gpus MATCHES "GPU 0")
      message(FATAL_ERROR "CMAKE_CUDA_ARCHITECTURES=native needs a GPU in this machine and there is none.\n"
                          "Fix: name the target, e.g. -DCMAKE_CUDA_ARCHITECTURES=90")
    endif()
  endif()
  execute_process(COMMAND ${CMAKE_CUDA_COMPILER} --list-gpu-arch OUTPUT_VARIABLE known_architectures
                  RESULT_VARIABLE cannot_list ERROR_QUIET)
  if(NOT cannot_list)
    string(REGEX MATCHALL "[0-9]+" known_architectures "${known_architectures}")
    foreach(architecture IN LISTS CMAKE_CUDA_ARCHITECTURES)
      if(architecture MATCHES "^([0-9]+)" AND NOT CMAKE_MATCH_1 IN_LIST known_architectures)
        string(REPLACE ";" " " known_text "${known_architectures}")
        message(FATAL_ERROR "CMAKE_CUDA_ARCHITECTURES contains ${architecture}, which this nvcc does not know "
                            "(${CMAKE_CUDA_COMPILER}).\nIt knows: ${known_text}.\n"
                            "Fix: e.g. -DCMAKE_CUDA_ARCHITECTURES=90, or use a toolkit that has it "
                            "(60 and 70 ended with CUDA 12).")
      endif()
    endforeach()
  endif()

  # The runtime goes into the library: hosts need no CUDA toolkit and may use another one themselves.
  set(CMAKE_CUDA_RUNTIME_LIBRARY Static)
  set(CMAKE_CUDA_STANDARD 17)
  set(CMAKE_CUDA_STANDARD_REQUIRED ON)
  set(CMAKE_CUDA_EXTENSIONS OFF)
  enable_language(CUDA)
  find_package(CUDAToolkit REQUIRED)

  add_library(meltsim_cuda_options INTERFACE)
  string(REPLACE ";" " " architectures_text "${CMAKE_CUDA_ARCHITECTURES}")
  # Two copies of CUB in one process clash unless each has a namespace of its own.
  target_compile_definitions(meltsim_cuda_options INTERFACE
    $<$<COMPILE_LANGUAGE:CUDA>:THRUST_CUB_WRAPPED_NAMESPACE=meltsim_cub>
    $<$<COMPILE_LANGUAGE:CUDA>:MELTSIM_CUDA_ARCHITECTURES="${architectures_text}">)
endif()
