if(TARGET fire3dv_passes)
  fire3dv_test(render_edits_test SOURCES edits_test.cpp bent_bar.cpp LINK fire3dv_render_bench LABELS render
               TIMEOUT 900)
endif()
