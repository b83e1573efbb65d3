# ROS 2 adapter.
if(TARGET fire3dv_ros2_dds)
  fire3dv_test(ros2_names_test SOURCES adapters/ros2_names_test.cpp adapters/ros2_domain_test.cpp
               LINK fire3dv_ros2_dds LABELS unit)
endif()
