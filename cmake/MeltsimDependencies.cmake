# SPDX-License-Identifier: Apache-2.0
# find_package with a message that names the Debian package. Nothing is ever downloaded.

# meltsim_find(<name> PACKAGE <debian package> PURPOSE <what is lost> [VERSION v] [COMPONENTS ...])
# Sets <name>_FOUND in the caller.
function(meltsim_find name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "PACKAGE;PURPOSE;VERSION" "COMPONENTS")
  set(components)
  if(arg_COMPONENTS)
    set(components COMPONENTS ${arg_COMPONENTS})
  endif()
  find_package(${name} ${arg_VERSION} QUIET ${components})
  set(${name}_FOUND ${${name}_FOUND} PARENT_SCOPE)
  if(NOT ${name}_FOUND)
    message(STATUS "meltsim: ${name} not found: ${arg_PURPOSE} (Debian/Ubuntu: apt install ${arg_PACKAGE})")
  endif()
endfunction()

# The same, but configuring stops when it is missing.
macro(meltsim_require name)
  cmake_parse_arguments(meltsim_require "" "PACKAGE;PURPOSE;VERSION" "COMPONENTS" ${ARGN})
  if(meltsim_require_COMPONENTS)
    find_package(${name} ${meltsim_require_VERSION} QUIET COMPONENTS ${meltsim_require_COMPONENTS})
  else()
    find_package(${name} ${meltsim_require_VERSION} QUIET)
  endif()
  if(NOT ${name}_FOUND)
    message(FATAL_ERROR "meltsim needs ${name} for ${meltsim_require_PURPOSE}.\n"
                        "Debian/Ubuntu: apt install ${meltsim_require_PACKAGE}")
  endif()
endmacro()
