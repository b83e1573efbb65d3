# Scenes of docs/gallery.md, and those with reference images by Cycles.
if(TARGET fire3dv_passes AND TARGET gallery_scenes_library)
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(openexr_of_goldens REQUIRED IMPORTED_TARGET OpenEXR)
  fire3dv_test(render_gallery_test SOURCES assets/gallery_test.cpp truth/cycles_test.cpp
               LINK fire3dv_render_bench fire3dv_scene gallery_scenes_library PkgConfig::openexr_of_goldens
               LABELS render TIMEOUT 900)
  target_compile_definitions(render_gallery_test PRIVATE
    FIRE3DV_CYCLES_GOLDENS="${PROJECT_SOURCE_DIR}/tests/render/goldens/cycles")
endif()
