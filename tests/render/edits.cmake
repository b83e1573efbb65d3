# Scene edits between frames, and background scene builds.
if(TARGET fire3dv_passes)
  fire3dv_test(render_edits_test SOURCES edits_test.cpp proofs/motion_quality_test.cpp support/bent_bar.cpp LINK fire3dv_render_bench LABELS render
               TIMEOUT 900)
  fire3dv_test(render_markers_test SOURCES markers_test.cpp image_markers_test.cpp proofs/limits_test.cpp LINK fire3dv_render_bench LABELS render TIMEOUT 900)
endif()
if(TARGET fire3dv_app)
  fire3dv_test(render_live_scene_test SOURCES live_scene_test.cpp path_requests_test.cpp screenshot_tiles_test.cpp LINK fire3dv_render_bench fire3dv_app LABELS render
               TIMEOUT 900)
endif()
