# Frame sinks and image comparison.
if(TARGET fire3dv_sinks)
  fire3dv_test(png_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/sinks/png_test.cpp LINK fire3dv_sinks LABELS unit cpu)
  fire3dv_test(file_sink_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/sinks/file_sink_test.cpp LINK fire3dv_sinks LABELS unit cpu)
  fire3dv_test(image_compare_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/drawing/image_compare_test.cpp LINK fire3dv_test_support fire3dv_sinks
               LABELS unit cpu)
endif()
if(TARGET fire3dv_jpeg)
  fire3dv_test(jpeg_encoder_test SOURCES sinks/jpeg_encoder_test.cpp LINK fire3dv_jpeg LABELS unit)
endif()
