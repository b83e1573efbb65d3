# glTF loader.
if(TARGET fire3dv_scene)
  fire3dv_test(scene_load_test SOURCES scene/scene_load_test.cpp scene/scene_material_test.cpp scene/scene_material_extensions_test.cpp
               geometry/scene_geometry_test.cpp
               LINK fire3dv_scene fire3dv_test_support LABELS unit)
  fire3dv_test(scene_images_test SOURCES textures/scene_images_test.cpp LINK fire3dv_scene fire3dv_test_support LABELS unit)
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(webp_to_write REQUIRED IMPORTED_TARGET libwebp)
  pkg_check_modules(zstd_to_write REQUIRED IMPORTED_TARGET libzstd)
  fire3dv_test(scene_ktx2_test SOURCES textures/scene_ktx2_test.cpp textures/basis_lz_test.cpp
               textures/basis_lz_huffman_test.cpp textures/uastc_test.cpp
               LINK fire3dv_scene fire3dv_test_support PkgConfig::zstd_to_write LABELS unit)
  fire3dv_test(scene_webp_test SOURCES textures/scene_webp_test.cpp LINK fire3dv_scene fire3dv_test_support PkgConfig::webp_to_write LABELS unit)
  fire3dv_test(mip_levels_test SOURCES geometry/mip_levels_test.cpp LINK fire3dv_scene LABELS unit)
  fire3dv_test(scene_instancing_test SOURCES scene/scene_instancing_test.cpp
               LINK fire3dv_scene fire3dv_state fire3dv_test_support LABELS unit)
  fire3dv_test(scene_meshopt_test SOURCES scene/scene_meshopt_test.cpp geometry/meshopt_vertices_test.cpp
               LINK fire3dv_scene fire3dv_test_support LABELS unit)
  fire3dv_test(scene_draco_test SOURCES scene/scene_draco_test.cpp
               LINK fire3dv_scene fire3dv_test_support LABELS unit)
  fire3dv_test(scene_extensions_test SOURCES scene/scene_extensions_test.cpp editing/export_glb_test.cpp editing/export_assets_test.cpp scene/specular_glossiness_test.cpp scene/scene_variants_test.cpp
               LINK fire3dv_scene fire3dv_test_support LABELS unit)
  fire3dv_test(scene_refuse_test SOURCES scene/scene_refuse_test.cpp scene/scene_files_test.cpp scene/foreign_file_test.cpp
               LINK fire3dv_scene fire3dv_test_support LABELS unit)
  fire3dv_test(scene_tangent_test SOURCES geometry/scene_tangent_test.cpp LINK fire3dv_scene fire3dv_test_support LABELS unit COLLECTION)
  target_compile_definitions(scene_tangent_test PRIVATE FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  fire3dv_test(scene_corpus_test SOURCES scene/scene_corpus_test.cpp LINK fire3dv_scene fire3dv_test_support LABELS unit COLLECTION)
  target_compile_definitions(scene_corpus_test PRIVATE FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endif()
