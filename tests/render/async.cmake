# Frames with an async compute queue.
if(TARGET fire3dv_passes)
  fire3dv_test(render_async_test SOURCES async_test.cpp support/bent_bar.cpp LINK fire3dv_render_bench LABELS render
               TIMEOUT 1200)
endif()
