# Golden images of URDF and MJCF robots.
if(TARGET fire3dv_passes AND TARGET fire3dv_descriptions)
  fire3dv_test(render_descriptions_test SOURCES assets/descriptions_test.cpp
               LINK fire3dv_render_bench fire3dv_descriptions fire3dv_convert_glb LABELS render TIMEOUT 900)
  target_compile_definitions(render_descriptions_test PRIVATE FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endif()
