# ROS 2 adapter.
if(TARGET fire3dv_ros2_dds)
  fire3dv_test(ros2_names_test SOURCES adapters/ros2/names_test.cpp adapters/ros2/domain_test.cpp
               LINK fire3dv_ros2_dds LABELS unit)
endif()
if(TARGET fire3dv_ros2_tf)
  fire3dv_test(ros2_tf_test SOURCES adapters/ros2/tf_test.cpp LINK fire3dv_ros2_tf LABELS unit)
  # Oracle: tf2 of ROS 1, where it is installed.
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(tf2_oracle QUIET IMPORTED_TARGET tf2)
  if(TARGET PkgConfig::tf2_oracle)
    # Debian 13's tf2.pc has no prefix, so that it names /include; the headers are in the compiler's own folders.
    get_target_property(tf2_folders PkgConfig::tf2_oracle INTERFACE_INCLUDE_DIRECTORIES)
    list(REMOVE_ITEM tf2_folders /include tf2_folders-NOTFOUND)
    set_target_properties(PkgConfig::tf2_oracle PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${tf2_folders}")
    add_library(fire3dv_tf2_oracle STATIC adapters/ros2/tf2_oracle.cpp)
    target_link_libraries(fire3dv_tf2_oracle PRIVATE fire3dv_flags PkgConfig::tf2_oracle)
    set_target_properties(fire3dv_tf2_oracle PROPERTIES CXX_STANDARD 17)
    fire3dv_test(ros2_tf_oracle_test SOURCES adapters/ros2/tf_oracle_test.cpp
                 LINK fire3dv_ros2_tf fire3dv_tf2_oracle LABELS unit)
  endif()
endif()
if(TARGET fire3dv_ros2_markers)
  fire3dv_test(ros2_markers_test SOURCES adapters/ros2/marker_store_test.cpp adapters/ros2/markers_test.cpp
               LINK fire3dv_ros2_markers LABELS unit)
endif()
if(TARGET fire3dv_ros2_program)
  fire3dv_test(ros2_robot_test SOURCES adapters/ros2/robot_test.cpp adapters/ros2/joint_scalars_test.cpp LINK fire3dv_ros2_program fire3dv_glb LABELS unit)
endif()
