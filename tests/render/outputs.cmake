# Output planes, and many cameras in one submission.
if(TARGET fire3dv_passes)
  fire3dv_test(render_outputs_test SOURCES outputs_test.cpp proofs/cast_rays.cpp many_cameras_test.cpp LINK fire3dv_render_bench LABELS render
               TIMEOUT 900)
endif()
