# Proofs of raster and shadow correctness on many scenes and views.
if(TARGET fire3dv_passes)
  fire3dv_library(fire3dv_proof_bench SOURCES support/proof_bench.cpp LINK fire3dv_render_bench)
  set(post_effects_more proofs/ray_effects_test.cpp proofs/diffuse_bounce_test.cpp)
  set(raster_limits_more proofs/tiles_test.cpp proofs/raster_variants_test.cpp proofs/coverage_merge_test.cpp)
  foreach(subject generations lod conservative_shadows shadow_techniques post post_effects thin_lens default_look watertight determinism raster_limits tangents light_sides)
    fire3dv_test(render_${subject}_test SOURCES proofs/${subject}_test.cpp ${${subject}_more} LINK fire3dv_proof_bench LABELS render
                 TIMEOUT 1800)
  endforeach()
  fire3dv_test(render_sensor_test SOURCES truth/sensor_test.cpp truth/lamps_test.cpp LINK fire3dv_proof_bench LABELS render TIMEOUT 1800)
  fire3dv_test(render_transparency_test SOURCES truth/transparency_test.cpp LINK fire3dv_proof_bench LABELS render TIMEOUT 1800)
endif()
