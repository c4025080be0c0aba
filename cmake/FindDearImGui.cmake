# SPDX-License-Identifier: Apache-2.0
# DearImGui_FOUND, target DearImGui::DearImGui: the library and its backends for GLFW and OpenGL 3. Debian and Ubuntu put
# the backends into the library and their headers into a folder of their own, and take stb out of it, which their
# package brings along; elsewhere it may be otherwise.
find_path(DEARIMGUI_INCLUDE_DIR imgui.h PATH_SUFFIXES imgui)
find_path(DEARIMGUI_BACKENDS_INCLUDE_DIR imgui_impl_opengl3.h HINTS ${DEARIMGUI_INCLUDE_DIR}
  PATH_SUFFIXES backends imgui/backends imgui)
find_library(DEARIMGUI_LIBRARY imgui)
find_library(DEARIMGUI_STB_LIBRARY stb)  # not every build of Dear ImGui needs it
mark_as_advanced(DEARIMGUI_INCLUDE_DIR DEARIMGUI_BACKENDS_INCLUDE_DIR DEARIMGUI_LIBRARY DEARIMGUI_STB_LIBRARY)
set(dearimgui_links ${CMAKE_DL_LIBS})
if(DEARIMGUI_STB_LIBRARY)
  list(PREPEND dearimgui_links ${DEARIMGUI_STB_LIBRARY})
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(DearImGui REQUIRED_VARS
  DEARIMGUI_LIBRARY DEARIMGUI_INCLUDE_DIR DEARIMGUI_BACKENDS_INCLUDE_DIR)
if(DearImGui_FOUND AND NOT TARGET DearImGui::DearImGui)
  add_library(DearImGui::DearImGui UNKNOWN IMPORTED)
  set_target_properties(DearImGui::DearImGui PROPERTIES IMPORTED_LOCATION ${DEARIMGUI_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES
      "${DEARIMGUI_INCLUDE_DIR};${DEARIMGUI_BACKENDS_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES "${dearimgui_links}")
endif()
