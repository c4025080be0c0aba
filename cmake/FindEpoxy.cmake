# SPDX-License-Identifier: Apache-2.0
# Epoxy_FOUND, target Epoxy::Epoxy: OpenGL's functions, found at run time.
find_path(EPOXY_INCLUDE_DIR epoxy/gl.h)
find_library(EPOXY_LIBRARY epoxy)
mark_as_advanced(EPOXY_INCLUDE_DIR EPOXY_LIBRARY)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Epoxy REQUIRED_VARS EPOXY_LIBRARY EPOXY_INCLUDE_DIR)
if(Epoxy_FOUND AND NOT TARGET Epoxy::Epoxy)
  add_library(Epoxy::Epoxy UNKNOWN IMPORTED)
  set_target_properties(Epoxy::Epoxy PROPERTIES IMPORTED_LOCATION ${EPOXY_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${EPOXY_INCLUDE_DIR})
endif()
