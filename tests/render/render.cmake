# Basic render tests: lifetime, formulas, environment, goldens, raster paths, transports.
if(TARGET fire3dv_passes)
  fire3dv_library(fire3dv_render_bench SOURCES support/render_bench.cpp support/scene_builder.cpp support/truth_scenes.cpp
                  support/material_tiles.cpp
                  LINK fire3dv_passes fire3dv_sinks fire3dv_test_support GTest::gtest)
  foreach(subject lifetime analytic image_based_lighting white_furnace anisotropy iridescence environment_cache many golden raster_paths stale_overlay)
    fire3dv_test(render_${subject}_test SOURCES ${subject}_test.cpp LINK fire3dv_render_bench LABELS render
                 TIMEOUT 900)
  endforeach()
  target_link_libraries(render_lifetime_test PRIVATE fire3dv_live_scene)
  fire3dv_test(render_material_energy_test SOURCES truth/material_energy_test.cpp LINK fire3dv_render_bench LABELS render
               TIMEOUT 900)
  fire3dv_test(render_path_test SOURCES truth/path_test.cpp truth/path_refinement_test.cpp
               LINK fire3dv_render_bench LABELS render TIMEOUT 900)
  fire3dv_test(render_path_glass_test SOURCES truth/path_glass_test.cpp LINK fire3dv_render_bench LABELS render
               TIMEOUT 900)
  fire3dv_test(render_environment_sun_test SOURCES truth/environment_sun_test.cpp LINK fire3dv_render_bench
               LABELS render TIMEOUT 900)
  fire3dv_test(render_identity_test SOURCES identity_test.cpp LINK fire3dv_render_bench fire3dv_app fire3dv::client
               LABELS render TIMEOUT 1200)
endif()
