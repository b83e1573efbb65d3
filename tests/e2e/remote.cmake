# Two virtual hosts with an impaired network between them: network namespaces, which need root.
# Without them the tests report that they are skipped.
if(COMMAND fire3dv_e2e_test)  # of programs.cmake
  foreach(case conditions held unmarked)
    fire3dv_e2e_test(networks_${case} SCRIPT links/networks_test.py
                     PROGRAMS fire3dv e2e_publisher fire3dv-impair fire3dv-motion CASES ${case})
    set_tests_properties(networks_${case} PROPERTIES SKIP_RETURN_CODE 77)
  endforeach()
  fire3dv_e2e_test(whole_frames SCRIPT links/whole_frames_test.py PROGRAMS fire3dv-impair fire3dv-motion fire3dv-record)
endif()
if(TARGET fire3dv AND TARGET bullet_arm)
  add_test(NAME remote_example
           COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/remote_example_test.py ${PROJECT_SOURCE_DIR}/examples/remote/README.md
                   $<TARGET_FILE_DIR:fire3dv>)
  set_tests_properties(remote_example PROPERTIES LABELS e2e TIMEOUT 1000 SKIP_RETURN_CODE 77
    ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1")
endif()
