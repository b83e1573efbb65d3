# MuJoCo adapter.
if(TARGET fire3dv_mujoco_program)
  fire3dv_test(mujoco_adapter_test SOURCES adapters/mujoco_adapter_test.cpp adapters/mujoco_markers_test.cpp
                       adapters/mujoco_publisher_test.cpp
               LINK fire3dv_mujoco_program fire3dv_mjcf fire3dv_wire fire3dv_transport fire3dv_test_support LABELS unit)
  target_compile_definitions(mujoco_adapter_test PRIVATE FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  fire3dv_test(mujoco_files_test SOURCES adapters/mujoco_file_checks_test.cpp adapters/mujoco_model_files_test.cpp
               LINK fire3dv_mujoco_compiled fire3dv_test_support LABELS unit)
  fire3dv_test(mjcf_oracle_test SOURCES convert/mjcf_oracle_test.cpp convert/mjcf_deformable_oracle_test.cpp
               LINK fire3dv_mujoco_compiled fire3dv_mjcf fire3dv_test_support LABELS unit COLLECTION)
  target_compile_definitions(mjcf_oracle_test PRIVATE FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endif()
