if(TARGET fire3dv_passes)
  fire3dv_test(render_outputs_test SOURCES outputs_test.cpp cast_rays.cpp many_cameras_test.cpp LINK fire3dv_render_bench LABELS render
               TIMEOUT 900)
endif()
