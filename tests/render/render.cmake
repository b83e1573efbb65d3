if(TARGET fire3dv_passes)
  fire3dv_library(fire3dv_render_bench SOURCES render_bench.cpp scene_builder.cpp
                  LINK fire3dv_passes fire3dv_sinks fire3dv_test_support GTest::gtest)
  foreach(subject lifetime analytic surroundings kept_surroundings many golden raster_paths held_mark)
    fire3dv_test(render_${subject}_test SOURCES ${subject}_test.cpp LINK fire3dv_render_bench LABELS render
                 TIMEOUT 900)
  endforeach()
  fire3dv_test(render_identity_test SOURCES identity_test.cpp LINK fire3dv_render_bench fire3dv_app fire3dv::client
               LABELS render TIMEOUT 1200)
endif()
