if(TARGET fire3dv_app)
  fire3dv_test(viewer_test SOURCES viewer_test.cpp viewer_scenes_test.cpp LINK fire3dv_app LABELS unit)
endif()
