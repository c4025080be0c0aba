# SPDX-License-Identifier: Apache-2.0
# An overlay port of the source tree that it lies in: vcpkg install meltsim --overlay-ports=packaging/vcpkg/ports
get_filename_component(SOURCE_PATH "${CURRENT_PORT_DIR}/../../../.." ABSOLUTE)

vcpkg_check_features(OUT_FEATURE_OPTIONS features FEATURES cuda MELTSIM_CUDA)
if(NOT "cuda" IN_LIST FEATURES)
  set(features -DMELTSIM_CUDA=OFF)
endif()
vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS ${features}
    -DMELTSIM_BUILD_TESTS=OFF
    -DMELTSIM_BUILD_EXAMPLES=OFF
    -DMELTSIM_BUILD_BENCHMARKS=OFF
    -DMELTSIM_CCACHE=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/meltsim)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
