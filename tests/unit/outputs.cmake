if(TARGET fire3dv_passes)
  fire3dv_test(image_outputs_test SOURCES image_outputs_test.cpp lens_test.cpp lens_opencv_test.cpp LINK fire3dv_passes fire3dv_sinks LABELS unit)
endif()
