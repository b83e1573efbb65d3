# Viewer input, cameras and scene replacement.
if(TARGET fire3dv_app)
  fire3dv_test(viewer_test SOURCES app/viewer_test.cpp app/viewer_scenes_test.cpp app/animation_timeline_test.cpp LINK fire3dv_app LABELS unit)
endif()
