# Output planes, and many cameras and worlds in one submission.
if(TARGET fire3dv_passes)
  fire3dv_test(render_outputs_test SOURCES outputs_test.cpp proofs/cast_rays.cpp many_cameras_test.cpp proofs/worlds_test.cpp support/bent_bar.cpp
               LINK fire3dv_render_bench LABELS render
               TIMEOUT 900)
endif()
