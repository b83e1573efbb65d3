# Image requests through the Python package.
include(${PROJECT_SOURCE_DIR}/cmake/PythonWithNumpy.cmake)
if(TARGET fire3dv AND NOT FIRE3DV_SANITIZE)
  foreach(case random_depth paths lockstep same_as_file all_outputs many_cameras several_devices lenses refusals fair_turns stop_request killed_clients restarted_renderer example)
    add_test(NAME images_${case}
      COMMAND ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/images_test.py $<TARGET_FILE:fire3dv> ${case})
    set_tests_properties(images_${case} PROPERTIES LABELS e2e TIMEOUT 900
      ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1;PYTHONPATH=${PROJECT_SOURCE_DIR}/adapters/generic/python:${CMAKE_CURRENT_LIST_DIR};FIRE3DV_CLIENT_LIBRARY=$<TARGET_FILE:fire3dv_client>")
  endforeach()
  # Compares rates within one run; one that another test disturbs is measured again.
  set_tests_properties(images_fair_turns PROPERTIES RUN_SERIAL TRUE)
endif()
