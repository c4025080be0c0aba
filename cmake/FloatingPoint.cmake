# SPDX-License-Identifier: Apache-2.0
# The one place that says how floating point is compiled, on the CPU and on the GPU.
#
# Default: contraction allowed (a*b+c may become one fused operation) and fast quotients on the GPU, so CPU and
# GPU agree within tolerances.
# MELTSIM_REPRODUCIBLE: neither, so the same operations give the same bits on both.
#
# -ffast-math never: it lets the compiler reorder sums (the order of neighbours is part of the result) and
# assume that NaN does not exist (the watchdog looks for it). Two of its harmless parts are on: errno after
# sqrt and trapping are used by nobody, and giving them up lets loops vectorise.
add_library(meltsim_floating_point INTERFACE)

set(host_options -fno-math-errno -fno-trapping-math)
set(device_options)
if(MELTSIM_REPRODUCIBLE)
  # exec/lane_positions.hpp: sums one by one, as on a GPU.
  target_compile_definitions(meltsim_floating_point INTERFACE MELTSIM_REPRODUCIBLE)
  list(APPEND host_options -ffp-contract=off)
  list(APPEND device_options --fmad=false)
else()
  list(APPEND host_options -ffp-contract=fast)
  # Single-precision quotients and roots good to 2 units in the last place instead of half of one, and numbers below
  # 1e-38 are zero.
  list(APPEND device_options --prec-div=false --prec-sqrt=false --ftz=true)
endif()
if(MELTSIM_NATIVE)
  list(APPEND host_options -march=native)
endif()

# Host code in .cu files gets the same host flags.
string(REPLACE ";" "," host_options_for_nvcc "${host_options}")
list(APPEND device_options -Xcompiler=${host_options_for_nvcc})
target_compile_options(meltsim_floating_point INTERFACE
  "$<$<COMPILE_LANGUAGE:CXX>:${host_options}>"
  "$<$<COMPILE_LANGUAGE:CUDA>:${device_options}>")
