if(TARGET fire3dv_passes)
  fire3dv_library(fire3dv_proof_bench SOURCES proof_bench.cpp LINK fire3dv_render_bench)
  set(raster_limits_more tiles_test.cpp raster_variants_test.cpp merged_surfaces_test.cpp)
  foreach(subject generations levels shadow_truth shadow_ways post watertight determinism raster_limits tangents)
    fire3dv_test(render_${subject}_test SOURCES ${subject}_test.cpp ${${subject}_more} LINK fire3dv_proof_bench LABELS render
                 TIMEOUT 1800)
  endforeach()
endif()
