# Skins and morph targets on the GPU.
if(TARGET fire3dv_passes)
  fire3dv_test(render_deform_test SOURCES deform_test.cpp support/bent_bar.cpp LINK fire3dv_render_bench LABELS render
               TIMEOUT 900 COLLECTION)
  target_compile_definitions(render_deform_test PRIVATE FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endif()
