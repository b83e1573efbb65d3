# Image requests through the Python package.
include(${PROJECT_SOURCE_DIR}/cmake/PythonWithNumpy.cmake)
if(TARGET fire3dv AND NOT FIRE3DV_SANITIZE)
  # Each case over shared memory; those that depend on the link over TCP, too. The rest over TCP: --long.
  set(image_cases paths same_as_file all_outputs many_cameras several_devices lenses stop_request example fair_turns)
  set(image_cases_of_links random_depth lockstep refusals killed_clients restarted_renderer)
  list(TRANSFORM image_cases APPEND _tcp OUTPUT_VARIABLE image_cases_over_tcp)
  foreach(case ${image_cases} ${image_cases_of_links} over_tcp)
    set(cases ${case})
    if(case IN_LIST image_cases)
      set(cases ${case}_shm)
    elseif(case STREQUAL "over_tcp")
      set(cases ${image_cases_over_tcp})
    endif()
    add_test(NAME images_${case}
      COMMAND ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/images_test.py $<TARGET_FILE:fire3dv> ${cases})
    set_tests_properties(images_${case} PROPERTIES LABELS e2e TIMEOUT 900
      ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1;PYTHONPATH=${PROJECT_SOURCE_DIR}/adapters/generic/python:${CMAKE_CURRENT_LIST_DIR};FIRE3DV_CLIENT_LIBRARY=$<TARGET_FILE:fire3dv_client>")
  endforeach()
  add_test(NAME draw_time COMMAND ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/draw_time_test.py $<TARGET_FILE:fire3dv>)
  get_test_property(images_refusals ENVIRONMENT image_environment)
  set_tests_properties(draw_time PROPERTIES LABELS e2e TIMEOUT 900 ENVIRONMENT "${image_environment}")
  set_tests_properties(images_over_tcp PROPERTIES LABELS long RUN_SERIAL TRUE)
  # Compares rates within one run; one that another test disturbs is measured again.
  set_tests_properties(images_fair_turns PROPERTIES RUN_SERIAL TRUE)
endif()
