# SPDX-License-Identifier: Apache-2.0
# `cpack -G DEB` (or TGZ) in a build folder: library, headers, CMake package and programs in one package.
set(CPACK_PACKAGE_NAME meltsim)
set(CPACK_PACKAGE_VENDOR "meltsim")
set(CPACK_PACKAGE_CONTACT "meltsim maintainers <maintainers@meltsim.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)  # dependencies follow from what was linked; needs dpkg-dev
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS OFF)
include(CPack)
