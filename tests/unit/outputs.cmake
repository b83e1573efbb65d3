# Output planes and lenses.
if(TARGET fire3dv_passes)
  fire3dv_test(image_outputs_test SOURCES drawing/image_outputs_test.cpp drawing/lens_test.cpp drawing/lens_opencv_test.cpp LINK fire3dv_passes fire3dv_sinks LABELS unit)
endif()
