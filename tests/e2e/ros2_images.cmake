# Images of fire3dv-ros2 in the ROS 2 graph, read by Cyclone DDS and, where it is installed, by Fast DDS.
include(${PROJECT_SOURCE_DIR}/cmake/PythonWithNumpy.cmake)
if(TARGET fire3dv AND TARGET fire3dv-ros2 AND NOT FIRE3DV_SANITIZE)
  fire3dv_program(ros2_image_peer SOURCES ros2/cyclone_peer.cpp LINK fire3dv_ros2_dds)
  set_target_properties(ros2_image_peer PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  set(fastdds_reader none)
  find_package(fastrtps QUIET)
  if(fastrtps_FOUND)
    fire3dv_program(ros2_fastdds_reader SOURCES ros2/fastdds_reader.cpp LINK fastrtps)
    set_target_properties(ros2_fastdds_reader PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
    set(fastdds_reader $<TARGET_FILE:ros2_fastdds_reader>)
  else()
    message(STATUS "Fast DDS 2 is not installed (libfastrtps-dev): images of fire3dv-ros2 are tested with Cyclone DDS alone")
  endif()
  foreach(case stamps planes demand stopped robot added_robot)
    add_test(NAME ros2_images_${case}
      COMMAND ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/ros2/ros2_images_test.py $<TARGET_FILE:fire3dv>
              $<TARGET_FILE:fire3dv-ros2> $<TARGET_FILE:ros2_image_peer> ${fastdds_reader} ${case})
    set_tests_properties(ros2_images_${case} PROPERTIES LABELS e2e TIMEOUT 900
      ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1;PYTHONPATH=${PROJECT_SOURCE_DIR}/adapters/generic/python;FIRE3DV_CLIENT_LIBRARY=$<TARGET_FILE:fire3dv_client>")
  endforeach()
endif()
