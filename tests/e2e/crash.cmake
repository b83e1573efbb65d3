# Simulators that are killed, and more of them than the machine has time for.
fire3dv_test(killed_writers_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/killed_writers_test.cpp
             LINK fire3dv_client fire3dv_transport fire3dv_wire LABELS e2e)
if(TARGET fire3dv)
  add_test(NAME killed_writer_drawn COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/killed_writer_drawn_test.py
           $<TARGET_FILE:fire3dv> $<TARGET_FILE:e2e_publisher>)
  set_tests_properties(killed_writer_drawn PROPERTIES LABELS e2e TIMEOUT 900
    ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1")
endif()
fire3dv_test(many_adapters_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/many_adapters_test.cpp
             LINK fire3dv_client fire3dv_transport fire3dv_wire LABELS e2e)
