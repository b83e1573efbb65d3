# Golden images of ADF scenes.
if(TARGET fire3dv_passes AND TARGET fire3dv_adf AND TARGET fire3dv_convert_glb)
  fire3dv_test(render_adf_golden_test SOURCES assets/adf_golden_test.cpp
               LINK fire3dv_render_bench fire3dv_adf fire3dv_convert_glb LABELS render TIMEOUT 900)
  target_compile_definitions(render_adf_golden_test PRIVATE FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endif()
