# MuJoCo adapter.
if(TARGET fire3dv_mujoco_program)
  fire3dv_test(mujoco_adapter_test SOURCES adapters/mujoco_adapter_test.cpp adapters/mujoco_publisher_test.cpp
               LINK fire3dv_mujoco_program fire3dv_wire fire3dv_transport fire3dv_test_support LABELS unit)
  target_compile_definitions(mujoco_adapter_test PRIVATE FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endif()
