# Golden images of URDF and MJCF robots; images of SDF worlds.
if(TARGET fire3dv_passes AND TARGET fire3dv_descriptions)
  fire3dv_test(render_descriptions_test SOURCES assets/descriptions_test.cpp
               LINK fire3dv_render_bench fire3dv_descriptions fire3dv_convert_glb LABELS render TIMEOUT 900)
  target_compile_definitions(render_descriptions_test PRIVATE FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endif()
if(TARGET fire3dv_passes AND TARGET fire3dv_sdf_reader)
  fire3dv_test(render_sdf_test SOURCES assets/sdf_world_test.cpp
               LINK fire3dv_render_bench fire3dv_descriptions fire3dv_convert_glb LABELS render TIMEOUT 900)
endif()
