# Tests of the example simulator: scene file and simulation.
if(TARGET bullet_arm)
  fire3dv_test(bullet_arm_simulation_test
    SOURCES bullet_arm/bullet_arm_simulation_test.cpp
    LINK bullet_arm_scene
    LABELS e2e)
  add_test(NAME bullet_arm_program_test
    COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/bullet_arm/bullet_arm_program_test.py $<TARGET_FILE:bullet_arm>
            ${CMAKE_CURRENT_BINARY_DIR}/bullet_arm_scene.glb)
  set_tests_properties(bullet_arm_program_test PROPERTIES LABELS e2e TIMEOUT 600)
endif()
