# Complete installation: the programs of `cmake --install` run from a moved prefix.
if(TARGET fire3dv AND TARGET bullet_arm)
  add_test(NAME install_programs
           COMMAND ${CMAKE_CURRENT_LIST_DIR}/install_programs_test.sh ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR} $<CONFIG>)
  set_tests_properties(install_programs PROPERTIES LABELS e2e TIMEOUT 300
    ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER}")
endif()
