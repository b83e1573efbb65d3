# Crash tests: killed simulators, and more simulators than the machine can serve.
fire3dv_test(killed_writers_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/programs/killed_writers_test.cpp
             LINK fire3dv_client fire3dv_transport fire3dv_wire LABELS e2e)
fire3dv_test(many_adapters_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/programs/many_adapters_test.cpp
             LINK fire3dv_client fire3dv_transport fire3dv_wire LABELS e2e)

# fire3dv_crash_script(name SCRIPT PROGRAM...)
function(fire3dv_crash_script name script)
  list(TRANSFORM ARGN REPLACE "(.+)" "$<TARGET_FILE:\\1>" OUTPUT_VARIABLE programs)
  add_test(NAME ${name} COMMAND python3 ${CMAKE_CURRENT_SOURCE_DIR}/${script} ${programs})
  set_tests_properties(${name} PROPERTIES LABELS e2e TIMEOUT 900
    ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1")
endfunction()
if(TARGET fire3dv)
  fire3dv_crash_script(killed_writer_drawn links/killed_writer_drawn_test.py fire3dv e2e_publisher)
  fire3dv_crash_script(transport_bench links/transport_bench_test.py fire3dv-bench)
endif()
