# fire3dv-gazebo against Debian 12's Gazebo Transport, where that is installed.
if(TARGET fire3dv-gazebo)
  find_package(ignition-transport11 QUIET)
  find_package(ignition-msgs8 QUIET)
  if(TARGET ignition-transport11::core AND TARGET ignition-msgs8::core)
    set(gz_types ${CMAKE_CURRENT_BINARY_DIR}/gz_types)
    add_custom_command(OUTPUT ${gz_types}/gz_types.pb.cc ${gz_types}/gz_types.pb.h
      COMMAND ${CMAKE_COMMAND} -E make_directory ${gz_types}
      COMMAND ${Protobuf_PROTOC_EXECUTABLE} --proto_path=${CMAKE_CURRENT_LIST_DIR}/gazebo --cpp_out=${gz_types} gz_types.proto
      DEPENDS ${CMAKE_CURRENT_LIST_DIR}/gazebo/gz_types.proto)
    add_executable(e2e_gazebo_peer gazebo/gazebo_peer.cpp ${gz_types}/gz_types.pb.cc)
    target_include_directories(e2e_gazebo_peer SYSTEM PRIVATE ${gz_types})
    target_link_libraries(e2e_gazebo_peer PRIVATE ignition-transport11::core ignition-msgs8::core)
    set_target_properties(e2e_gazebo_peer PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
    if(TARGET fire3dv)
      foreach(cases prefix entities restart choice hostile hosts password added drawn)
        add_test(NAME gazebo_${cases} COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/gazebo/gazebo_test.py $<TARGET_FILE:fire3dv>
                 $<TARGET_FILE:fire3dv-gazebo> $<TARGET_FILE:e2e_gazebo_peer> $<TARGET_FILE:stream_dump> ${cases})
        set_tests_properties(gazebo_${cases} PROPERTIES LABELS e2e TIMEOUT 900 SKIP_RETURN_CODE 77
          ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1")
      endforeach()
    endif()
  else()
    message(STATUS "ignition-transport is not installed (libignition-transport-dev): fire3dv-gazebo is tested without it")
  endif()
endif()
