# SPDX-License-Identifier: Apache-2.0
# Install and package rules: headers, library, CMake package, pkg-config file.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/meltsim)

# Where not everything was built, what is there is installed.
install(CODE "if(NOT EXISTS \"$<TARGET_FILE:meltsim>\")
  message(FATAL_ERROR \"meltsim: the library is not built; build it first: cmake --build ${PROJECT_BINARY_DIR} --target meltsim\")
endif()")
install(TARGETS meltsim EXPORT meltsimTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/meltsim
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp" PATTERN "*.def")
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(EXPORT meltsimTargets NAMESPACE meltsim:: DESTINATION ${package_dir})

# A static library passes its dependencies on to the host; the shared one keeps them to itself.
set(config_static_dependencies "")
set(config_static_runtime "")
set(pc_libs_private "")
if(NOT BUILD_SHARED_LIBS)
  string(APPEND config_static_dependencies "find_dependency(Threads)\n")
  if(MELTSIM_HAVE_CUDA)
    string(APPEND config_static_dependencies "find_dependency(CUDAToolkit)\n")
  endif()
  if(MELTSIM_ASSIMP)
    string(APPEND config_static_dependencies "find_dependency(assimp)\n")
  endif()
  # pkg-config hosts, and projects in C alone, link with whatever compiler they have, so the C++ runtime is named outright.
  set(cxx_runtime stdc++)
  if("c++" IN_LIST CMAKE_CXX_IMPLICIT_LINK_LIBRARIES)
    set(cxx_runtime c++)
  endif()
  set(config_static_runtime "# CMake links a project in C alone by its C compiler, which brings no C++ runtime.
get_property(meltsim_languages GLOBAL PROPERTY ENABLED_LANGUAGES)
if(NOT \"CXX\" IN_LIST meltsim_languages)
  set_property(TARGET meltsim::meltsim APPEND PROPERTY INTERFACE_LINK_LIBRARIES ${cxx_runtime} m)
endif()
unset(meltsim_languages)
")
  set(pc_libs_private "-l${cxx_runtime} -lm -lpthread")
  if(MELTSIM_ASSIMP)
    string(PREPEND pc_libs_private "-lassimp ")
  endif()
  if(MELTSIM_HAVE_CUDA)
    get_target_property(cudart_static CUDA::cudart_static IMPORTED_LOCATION)
    get_filename_component(cudart_directory ${cudart_static} DIRECTORY)
    string(PREPEND pc_libs_private "-L${cudart_directory} -lcudart_static -ldl -lrt ")
  endif()
endif()

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/meltsimConfig.cmake.in
  ${PROJECT_BINARY_DIR}/cmake/meltsimConfig.cmake
  INSTALL_DESTINATION ${package_dir}
  NO_SET_AND_CHECK_MACRO)
# 0.x: a minor version may break its hosts, so it only satisfies requests for itself.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/cmake/meltsimConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/cmake/meltsimConfig.cmake
              ${PROJECT_BINARY_DIR}/cmake/meltsimConfigVersion.cmake
  DESTINATION ${package_dir})

# Relative to where the .pc file lies, so the prefix can be moved.
file(RELATIVE_PATH pc_to_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" pc_to_prefix "${pc_to_prefix}")
configure_file(${PROJECT_SOURCE_DIR}/cmake/meltsim.pc.in ${PROJECT_BINARY_DIR}/cmake/meltsim.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/cmake/meltsim.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
