# SPDX-License-Identifier: Apache-2.0
# Installs a program where it was built; where it was not, says how to build it and goes on.
function(meltsim_install_program target)
  install(TARGETS ${target} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} OPTIONAL)
  install(CODE "if(NOT EXISTS \"$<TARGET_FILE:${target}>\")
  message(STATUS \"Left out, as it is not built: $<TARGET_FILE_NAME:${target}> (cmake --build ${PROJECT_BINARY_DIR} --target ${target})\")
endif()")
endfunction()
