# SPDX-License-Identifier: Apache-2.0
# meltsim_reader: scenes from text, the World that a scene describes, checkpoints and the replay page. The runner and the Python module
# link it, so it is position-independent. Included by the directories of both; the first makes the target.
if(TARGET meltsim_reader)
  return()
endif()
include(MeltsimPrecompile)
set(reader_dir ${CMAKE_CURRENT_LIST_DIR})

# Built-in scenes are text inside the program: it needs no path at run time.
file(GLOB scene_files CONFIGURE_DEPENDS ${reader_dir}/../scenes/*.yaml)
set(embedded_entries "")
foreach(scene_file IN LISTS scene_files)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${scene_file})
  get_filename_component(scene_name ${scene_file} NAME_WE)
  file(READ ${scene_file} scene_text)
  string(APPEND embedded_entries "    \"${scene_name}\", R\"MELTSCENE(${scene_text})MELTSCENE\",\n")
endforeach()
configure_file(${reader_dir}/embedded_scenes.cpp.in embedded_scenes.cpp @ONLY)

# So is the replay page.
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${reader_dir}/show/replay.html)
file(READ ${reader_dir}/show/replay.html replay_html)
configure_file(${reader_dir}/show/replay_html.cpp.in replay_html.cpp @ONLY)

add_library(meltsim_reader STATIC
  ${reader_dir}/builtin.cpp
  ${reader_dir}/build_world.cpp
  ${reader_dir}/check_heat.cpp
  ${reader_dir}/check_units.cpp
  ${reader_dir}/checkpoint.cpp
  ${reader_dir}/csv.cpp
  ${reader_dir}/files.cpp
  ${reader_dir}/item_options.cpp
  ${reader_dir}/library_error.cpp
  ${reader_dir}/load_contents.cpp
  ${reader_dir}/load_heat.cpp
  ${reader_dir}/load_materials.cpp
  ${reader_dir}/load_output.cpp
  ${reader_dir}/load_probes.cpp
  ${reader_dir}/load_scene.cpp
  ${reader_dir}/merge_keys.cpp
  ${reader_dir}/load_settings.cpp
  ${reader_dir}/load_shape.cpp
  ${reader_dir}/load_trade.cpp
  ${reader_dir}/memory.cpp
  ${reader_dir}/node.cpp
  ${reader_dir}/numbers.cpp
  ${reader_dir}/option_values.cpp
  ${reader_dir}/overrides.cpp
  ${reader_dir}/particle_files.cpp
  ${reader_dir}/probes.cpp
  ${reader_dir}/resolution.cpp
  ${reader_dir}/scene_options.cpp
  ${reader_dir}/suggest.cpp
  ${reader_dir}/show/camera.cpp
  ${reader_dir}/show/deflate.cpp
  ${reader_dir}/show/replay.cpp
  ${reader_dir}/show/replay_page.cpp
  ${CMAKE_CURRENT_BINARY_DIR}/embedded_scenes.cpp
  ${CMAKE_CURRENT_BINARY_DIR}/replay_html.cpp)
set_target_properties(meltsim_reader PROPERTIES POSITION_INDEPENDENT_CODE ON
  CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)  # the Python module exports its entry alone
target_include_directories(meltsim_reader PUBLIC ${reader_dir})
target_link_libraries(meltsim_reader
  PUBLIC meltsim::meltsim yaml-cpp::yaml-cpp nlohmann_json::nlohmann_json
  PRIVATE meltsim_warnings fmt::fmt ZLIB::ZLIB)
target_compile_options(meltsim_reader PRIVATE -Wpedantic -Wshadow)
# Most of it reads a scene: a fifth less to compile, and nobody waits for it. What packs particles does compute.
target_compile_options(meltsim_reader PRIVATE $<$<CONFIG:Release>:-O1>)
foreach(name particle_files show/deflate show/replay show/replay_page)
  set_source_files_properties(${reader_dir}/${name}.cpp PROPERTIES COMPILE_OPTIONS $<$<CONFIG:Release>:-O3>
    SKIP_PRECOMPILE_HEADERS ON)
endforeach()
meltsim_precompile(meltsim_reader <meltsim/meltsim.hpp> <nlohmann/json.hpp> <yaml-cpp/yaml.h> <fmt/format.h>)
meltsim_compile_together(meltsim_reader)
