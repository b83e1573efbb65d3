# Conversion of robot description files.
if(TARGET fire3dv_convert_glb)
  fire3dv_test(write_glb_test SOURCES convert/jpeg_check_test.cpp convert/write_glb_test.cpp
               LINK fire3dv_convert_glb fire3dv_scene fire3dv_test_support LABELS unit)
  fire3dv_test(conversion_record_test SOURCES convert/conversion_record_test.cpp
               LINK fire3dv_scene fire3dv_test_support LABELS unit)
  fire3dv_test(sdf_names_test SOURCES convert/sdf_names_test.cpp LINK fire3dv_base fire3dv_test_support LABELS unit)
  if(TARGET fire3dv_sdf_reader)
    fire3dv_test(read_sdf_test SOURCES convert/sdf/read_sdf_test.cpp convert/sdf/sdf_files_test.cpp convert/sdf/sdf_joints_test.cpp
                 LINK fire3dv_descriptions fire3dv_test_support LABELS unit)
  endif()
  fire3dv_test(description_kind_test SOURCES convert/description_kind_test.cpp
               LINK fire3dv_description_files fire3dv_test_support LABELS unit)
  fire3dv_test(read_urdf_test SOURCES convert/read_urdf_test.cpp LINK fire3dv_urdf fire3dv_test_support LABELS unit)
  fire3dv_test(mesh_scene_test SOURCES convert/mesh_scene_test.cpp convert/three_mf_test.cpp
               LINK fire3dv_descriptions fire3dv_test_support LABELS unit)
  fire3dv_test(xacro_test SOURCES convert/xacro_expression_test.cpp convert/xacro_test.cpp
               LINK fire3dv_urdf fire3dv_test_support LABELS unit)
  fire3dv_test(read_mjcf_test SOURCES convert/read_mjcf_test.cpp convert/mjcf_features_test.cpp convert/mjcf_assets_test.cpp
                       convert/mjcf_builtin_mesh_test.cpp convert/mjcf_composite_test.cpp convert/mjcf_flex_test.cpp
                       convert/mjcf_skins_test.cpp
               LINK fire3dv_mjcf fire3dv_test_support LABELS unit)
endif()
