# Debug views, picks, outlines, and edits of a viewer's user.
if(TARGET fire3dv_passes)
  fire3dv_test(render_inspect_test SOURCES inspect_test.cpp user_edits_test.cpp support/bent_bar.cpp LINK fire3dv_render_bench LABELS render
               TIMEOUT 900)
endif()
