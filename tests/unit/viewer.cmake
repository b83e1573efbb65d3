# Viewer input, cameras, guides, configuration file, scene replacement and messages of the live view.
if(TARGET fire3dv_app)
  fire3dv_test(viewer_test SOURCES app/viewer_test.cpp app/viewer_scenes_test.cpp app/measurement_test.cpp window/guides_test.cpp window/config_test.cpp window/recent_files_test.cpp window/screenshot_tiles_test.cpp editing/scene_editor_test.cpp editing/editor_additions_test.cpp editing/editor_settings_test.cpp app/animation_timeline_test.cpp app/live/live_messages_test.cpp app/live/live_plots_test.cpp LINK fire3dv_app LABELS unit)
endif()
