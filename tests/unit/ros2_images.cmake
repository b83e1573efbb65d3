# Images of the ROS 2 adapter.
if(TARGET fire3dv_ros2_images)
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(urdfdom_headers REQUIRED IMPORTED_TARGET urdfdom_headers)
  fire3dv_test(ros2_cameras_test
    SOURCES ros2_images/camera_spec_test.cpp ros2_images/image_bytes_test.cpp ros2_images/sensor_tags_test.cpp
    LINK fire3dv_ros2_cameras PkgConfig::urdfdom_headers LABELS unit)
  fire3dv_test(ros2_camera_topics_test SOURCES ros2_images/camera_topics_test.cpp
               LINK fire3dv_ros2_images LABELS unit)
  fire3dv_test(ros2_camera_options_test
    SOURCES ros2_images/camera_mount_test.cpp ros2_images/camera_options_test.cpp
    LINK fire3dv_ros2_images LABELS unit)
endif()
