# The first examples of the README, and examples dataset, stereo_endoscope and environments: runs what their READMEs show.
include(${PROJECT_SOURCE_DIR}/cmake/PythonWithNumpy.cmake)
if(TARGET fire3dv AND TARGET bullet_arm AND NOT FIRE3DV_SANITIZE)  # Python cannot load a client with a sanitizer
  foreach(case dataset stereo_endoscope environments)
    add_test(NAME python_example_${case}
      COMMAND ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/python_examples_test.py $<TARGET_FILE:fire3dv>
              $<TARGET_FILE:bullet_arm> ${case})
    set_tests_properties(python_example_${case} PROPERTIES LABELS e2e TIMEOUT 900
      ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1;PYTHONPATH=${PROJECT_SOURCE_DIR}/adapters/generic/python;FIRE3DV_CLIENT_LIBRARY=$<TARGET_FILE:fire3dv_client>")
  endforeach()
  if(TARGET fire3dv-record)
    add_test(NAME python_example_needle_dataset
      COMMAND ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/needle_dataset_test.py $<TARGET_FILE:fire3dv>)
    set_tests_properties(python_example_needle_dataset PROPERTIES LABELS e2e TIMEOUT 900
      ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1;PYTHONPATH=${PROJECT_SOURCE_DIR}/adapters/generic/python;FIRE3DV_CLIENT_LIBRARY=$<TARGET_FILE:fire3dv_client>")
  endif()
  add_test(NAME readme
    COMMAND ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/readme_test.py $<TARGET_FILE:fire3dv>
            $<TARGET_FILE:bullet_arm> $<TARGET_FILE:fire3dv_client> ${CMAKE_C_COMPILER})
  set_tests_properties(readme PROPERTIES LABELS e2e TIMEOUT 900
    ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1;PYTHONPATH=${PROJECT_SOURCE_DIR}/adapters/generic/python;FIRE3DV_CLIENT_LIBRARY=$<TARGET_FILE:fire3dv_client>")
endif()
