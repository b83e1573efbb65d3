# AMBF plugin: options, cameras, session, recording, and the plugin against the API stub.
if(TARGET fire3dv_ambf)
  set(ambf_tests ${PROJECT_SOURCE_DIR}/tests/ambf)
  fire3dv_test(ambf_recording_test SOURCES adapters/ambf_recording_test.cpp LINK fire3dv_record fire3dv_adf LABELS unit)
  target_compile_definitions(ambf_recording_test PRIVATE FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  fire3dv_test(ambf_test SOURCES adapters/ambf_options_test.cpp adapters/ambf_cameras_test.cpp adapters/ambf_session_test.cpp
               LINK fire3dv_ambf fire3dv_scene fire3dv_test_support LABELS unit)

  # The plugin as AMBF loads it, compiled against the API stub of tests/ambf/api.
  add_library(ambf_plugin_alone MODULE ${PROJECT_SOURCE_DIR}/adapters/ambf/plugin.cpp)
  target_link_libraries(ambf_plugin_alone PRIVATE fire3dv_flags fire3dv_ambf)
  target_include_directories(ambf_plugin_alone PRIVATE ${ambf_tests}/api)
  target_link_options(ambf_plugin_alone PRIVATE
                      -Wl,--version-script=${PROJECT_SOURCE_DIR}/adapters/ambf/exports.map)
  set_target_properties(ambf_plugin_alone PROPERTIES
    CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  fire3dv_test(ambf_plugin_test SOURCES adapters/ambf_plugin_test.cpp adapters/ambf_plugin_end_test.cpp allocation_count.cpp
               LINK fire3dv_wire fire3dv_transport ${CMAKE_DL_LIBS} LABELS unit)
  target_include_directories(ambf_plugin_test PRIVATE ${ambf_tests}/api)
  target_compile_definitions(ambf_plugin_test PRIVATE AMBF_PLUGIN="$<TARGET_FILE:ambf_plugin_alone>")
  add_dependencies(ambf_plugin_test ambf_plugin_alone)
  add_test(NAME ambf_plugin_exports
    COMMAND ${CMAKE_COMMAND} -D NM=${CMAKE_NM} -D LIBRARY=$<TARGET_FILE:ambf_plugin_alone>
            -P ${CMAKE_CURRENT_LIST_DIR}/scripts/ambf_plugin_exports.cmake)
  set_tests_properties(ambf_plugin_exports PROPERTIES LABELS "unit;cpu" TIMEOUT 60)
endif()
