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
set(license_dir ${CMAKE_INSTALL_DOCDIR})
if(NOT is_top_level)
  set(license_dir ${CMAKE_INSTALL_DATAROOTDIR}/doc/meltsim)  # the other one is the host's, with the host's LICENSE
endif()
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${license_dir})
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

set(pc_cflags "")
if(NOT BUILD_SHARED_LIBS AND NOT SKBUILD)
  set(pc_cflags " -DMELTSIM_STATIC")
endif()
# Relative to where the .pc file lies, so the prefix can be moved. Not in /usr: pkg-config knows directories of the system by their
# names, and leaves them out, as compilers look there last. Directories that are absolute stay what they are.
foreach(kind LIBDIR INCLUDEDIR)
  string(TOLOWER pc_${kind} variable)
  set(${variable} "\${prefix}/${CMAKE_INSTALL_${kind}}")
  if(IS_ABSOLUTE "${CMAKE_INSTALL_${kind}}")
    set(${variable} "${CMAKE_INSTALL_${kind}}")
  endif()
endforeach()
set(pc_prefix /usr)
configure_file(${PROJECT_SOURCE_DIR}/cmake/meltsim.pc.in ${PROJECT_BINARY_DIR}/cmake/system/meltsim.pc @ONLY)
file(RELATIVE_PATH pc_to_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" pc_to_prefix "${pc_to_prefix}")
set(pc_prefix "\${pcfiledir}/${pc_to_prefix}")
if(IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}")
  set(pc_prefix "${CMAKE_INSTALL_PREFIX}")
endif()
configure_file(${PROJECT_SOURCE_DIR}/cmake/meltsim.pc.in ${PROJECT_BINARY_DIR}/cmake/meltsim.pc @ONLY)
# Only when it is installed is the prefix known.
install(CODE "set(meltsim_pc \"${PROJECT_BINARY_DIR}/cmake/meltsim.pc\")
if(CMAKE_INSTALL_PREFIX STREQUAL \"/usr\")
  set(meltsim_pc \"${PROJECT_BINARY_DIR}/cmake/system/meltsim.pc\")
endif()
set(meltsim_pc_directory \"${CMAKE_INSTALL_LIBDIR}/pkgconfig\")
if(NOT IS_ABSOLUTE \"\${meltsim_pc_directory}\")
  string(PREPEND meltsim_pc_directory \"\${CMAKE_INSTALL_PREFIX}/\")
endif()
file(INSTALL \"\${meltsim_pc}\" DESTINATION \"\${meltsim_pc_directory}\")")
