# Offline rendering of recordings: against itself and against images of the live run.
if(TARGET fire3dv)
  fire3dv_program(e2e_offline_recording SOURCES ${CMAKE_CURRENT_LIST_DIR}/programs/offline_recording.cpp LINK fire3dv_record)
  set_target_properties(e2e_offline_recording PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  add_test(NAME offline
    COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/offline_test.py $<TARGET_FILE:fire3dv> $<TARGET_FILE:fire3dv-record>
            $<TARGET_FILE:fire3dv-replay> $<TARGET_FILE:e2e_publisher> $<TARGET_FILE:e2e_offline_recording>)
  include(${PROJECT_SOURCE_DIR}/cmake/PythonWithNumpy.cmake)
  add_test(NAME stop
    COMMAND ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/stop_test.py $<TARGET_FILE:fire3dv> $<TARGET_FILE:e2e_publisher>
            $<TARGET_FILE:fire3dv-inspect> $<TARGET_FILE:e2e_offline_recording>)
  foreach(part dataset dataset_inputs dataset_containers dataset_flow dataset_randomize dataset_dask)
    add_test(NAME ${part}
      COMMAND ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/dataset/${part}_test.py $<TARGET_FILE:fire3dv> $<TARGET_FILE:e2e_offline_recording>)
  endforeach()
  foreach(part relabel relabel_joints relabel_lerobot)
    add_test(NAME ${part}
      COMMAND ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/dataset/${part}_test.py $<TARGET_FILE:fire3dv>)
  endforeach()
  add_test(NAME verify
    COMMAND ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/verify/verify_test.py $<TARGET_FILE:fire3dv> $<TARGET_FILE:e2e_offline_recording>
            live changes hostile datasets)
  add_test(NAME verify_formats
    COMMAND ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/verify/verify_test.py $<TARGET_FILE:fire3dv> $<TARGET_FILE:e2e_offline_recording>
            formats frames)
  set_tests_properties(verify verify_formats PROPERTIES
    ENVIRONMENT_MODIFICATION "PYTHONPATH=path_list_append:${CMAKE_CURRENT_LIST_DIR}/dataset")
  set_tests_properties(offline relabel relabel_joints relabel_lerobot stop verify verify_formats dataset dataset_inputs dataset_containers dataset_flow dataset_randomize dataset_dask PROPERTIES LABELS e2e TIMEOUT 900
    ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1;PYTHONPATH=${PROJECT_SOURCE_DIR}/adapters/generic/python;FIRE3DV_CLIENT_LIBRARY=$<TARGET_FILE:fire3dv_client>")
  set_tests_properties(dataset_dask PROPERTIES LABELS long)  # the start of five Python programs
  add_test(NAME truth_page
    COMMAND ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/scripts/truth_page_test.py ${PROJECT_SOURCE_DIR} $<TARGET_FILE:fire3dv>)
  set_tests_properties(truth_page PROPERTIES LABELS e2e TIMEOUT 300
    ENVIRONMENT "PYTHONDONTWRITEBYTECODE=1;VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER}")
endif()
