if(TARGET fire3dv_scene)
  fire3dv_test(radiance_file_test SOURCES radiance_file_test.cpp LINK fire3dv_scene fire3dv_test_support LABELS unit)
endif()
