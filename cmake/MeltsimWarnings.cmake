# SPDX-License-Identifier: Apache-2.0
# Warnings for this project's own code; never passed on to hosts.
add_library(meltsim_warnings INTERFACE)
target_compile_options(meltsim_warnings INTERFACE
  $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra>
  $<$<COMPILE_LANGUAGE:CUDA>:-Xcompiler=-Wall,-Wextra>)
if(MELTSIM_WARNINGS_AS_ERRORS)
  target_compile_options(meltsim_warnings INTERFACE
    $<$<COMPILE_LANGUAGE:CXX>:-Werror>
    "$<$<COMPILE_LANGUAGE:CUDA>:SHELL:-Werror all-warnings -Xcompiler=-Werror>")
endif()
