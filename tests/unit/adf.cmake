# Mesh files and the ADF reader.
if(TARGET fire3dv_mesh_files)
  fire3dv_test(mesh_files_test SOURCES convert/mesh_files_test.cpp
               LINK fire3dv_mesh_files fire3dv_test_support LABELS unit)
endif()
if(TARGET fire3dv_adf)
  fire3dv_test(adf_test SOURCES convert/adf_scene_test.cpp convert/adf_refuse_test.cpp
               LINK fire3dv_adf fire3dv_test_support LABELS unit)
  target_compile_definitions(adf_test PRIVATE FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endif()
