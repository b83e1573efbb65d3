# Short run of the demo: executes the commands of the README. Other transports: --long.
if(TARGET fire3dv AND TARGET bullet_arm)
  foreach(transport shm tcp udp)
    add_test(NAME demo_${transport}
             COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/demo_test.py ${PROJECT_SOURCE_DIR}/tools/demo.sh
                     $<TARGET_FILE_DIR:fire3dv> ${transport})
    set_tests_properties(demo_${transport} PROPERTIES LABELS long TIMEOUT 600
      ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER}")
  endforeach()
  set_tests_properties(demo_shm PROPERTIES LABELS e2e)
endif()
