# Valid and broken assets, from public collections and generated.
if(TARGET fire3dv_passes AND TARGET gallery_scenes_library)
  fire3dv_library(fire3dv_asset_tests SOURCES assets/asset_collection.cpp assets/asset_oracles.cpp proofs/computed_coverage.cpp
                  LINK fire3dv_render_bench fire3dv_contact_sheet_parts fire3dv_scene gallery_scenes_library)
  target_compile_definitions(fire3dv_asset_tests PUBLIC FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
                             FIRE3DV_IMAGE_DIR="${PROJECT_BINARY_DIR}/tests/images")
  foreach(subject assets broken_assets)
    fire3dv_test(render_${subject}_test SOURCES assets/${subject}_test.cpp LINK fire3dv_asset_tests LABELS render
                 TIMEOUT 900 COLLECTION)
  endforeach()
endif()
