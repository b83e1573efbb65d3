# ROS 2 adapter, with publishers on both DDS libraries of ROS 2.
if(TARGET fire3dv-ros2 AND TARGET fire3dv-convert AND TARGET stream_dump)
  add_library(e2e_ros2_commands STATIC programs/ros2/commands.cpp)
  target_link_libraries(e2e_ros2_commands PUBLIC fire3dv_flags)
  fire3dv_program(e2e_cyclone_publisher SOURCES programs/ros2/cyclone_publisher.cpp
                  LINK e2e_ros2_commands fire3dv_ros2_messages)
  add_dependencies(e2e_cyclone_publisher fire3dv_ros2_messages_generated)
  set(ros2_publishers e2e_cyclone_publisher)
  find_package(fastrtps QUIET)
  if(fastrtps_FOUND)
    fire3dv_program(e2e_fastdds_publisher SOURCES programs/ros2/fastdds_publisher.cpp
                    LINK e2e_ros2_commands fastrtps fastcdr)
    list(APPEND ros2_publishers e2e_fastdds_publisher)
  else()
    message(STATUS "Fast DDS 2 is not installed (libfastrtps-dev): its part of the tests of fire3dv-ros2 is left out")
  endif()
  set_target_properties(${ros2_publishers} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  foreach(publisher ${ros2_publishers})
    string(REGEX REPLACE "e2e_(.*)_publisher" "\\1" library ${publisher})
    set(all_cases frames robot times hostile large)
    if(library STREQUAL "cyclone")
      list(APPEND all_cases markers)
    endif()
    foreach(cases ${all_cases})
      add_test(NAME ros2_${library}_${cases}
        COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/ros2/ros2_test.py $<TARGET_FILE:fire3dv-ros2> $<TARGET_FILE:stream_dump>
                $<TARGET_FILE:${publisher}> ${cases})
      set_tests_properties(ros2_${library}_${cases} PROPERTIES LABELS e2e TIMEOUT 900 SKIP_RETURN_CODE 77
        ENVIRONMENT "PYTHONDONTWRITEBYTECODE=1")
    endforeach()
  endforeach()
  if(TARGET fire3dv)
    add_test(NAME ros2_drawn COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/ros2/ros2_drawn_test.py $<TARGET_FILE:fire3dv>
             $<TARGET_FILE:fire3dv-ros2> $<TARGET_FILE:e2e_cyclone_publisher>)
    set_tests_properties(ros2_drawn PROPERTIES LABELS e2e TIMEOUT 900 SKIP_RETURN_CODE 77
      ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1")
  endif()
endif()
