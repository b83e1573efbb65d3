# Output planes, and many cameras and worlds in one submission.
if(TARGET fire3dv_passes)
  fire3dv_test(render_outputs_test SOURCES outputs_test.cpp proofs/cast_rays.cpp many_cameras_test.cpp proofs/worlds_test.cpp support/bent_bar.cpp
               LINK fire3dv_render_bench LABELS render
               TIMEOUT 900)
  fire3dv_test(render_labels_test
               SOURCES labels/flow_test.cpp labels/lens_labels_test.cpp labels/motion_test.cpp labels/occlusion_test.cpp
                       labels/surface_labels_test.cpp proofs/cast_rays.cpp support/bent_bar.cpp
               LINK fire3dv_render_bench fire3dv_capture LABELS render TIMEOUT 900)
endif()
