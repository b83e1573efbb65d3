# Files of containers/: options, ports and names; the renderer as the pool runs it.
execute_process(COMMAND python3 -c "import yaml" RESULT_VARIABLE fire3dv_no_yaml OUTPUT_QUIET ERROR_QUIET)
if(TARGET fire3dv AND TARGET bullet_arm AND NOT fire3dv_no_yaml)
  add_test(NAME containers COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/scripts/containers_test.py ${PROJECT_SOURCE_DIR}
           $<TARGET_FILE:fire3dv> $<TARGET_FILE:bullet_arm>)
  set_tests_properties(containers PROPERTIES LABELS e2e TIMEOUT 600
    ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER}")
else()
  message(STATUS "The test \"containers\" is left out: it needs the renderer, the examples and python3-yaml")
endif()
