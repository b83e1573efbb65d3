# Images of fire3dv-ros2: cameras, their messages and the encoder.
find_package(PkgConfig REQUIRED)
pkg_check_modules(tinyxml2 REQUIRED IMPORTED_TARGET tinyxml2)
fire3dv_library(fire3dv_ros2_cameras
  SOURCES images/camera_model.cpp images/camera_spec.cpp images/image_bytes.cpp
          images/sensor_tags.cpp
  LINK fire3dv_ros2_dds fire3dv::client fire3dv_jpeg PkgConfig::tinyxml2)
find_package(CLI11 REQUIRED)
fire3dv_library(fire3dv_ros2_images
  SOURCES images/camera_images.cpp images/camera_mount.cpp images/camera_options.cpp images/camera_topics.cpp
          images/image_output.cpp images/image_worker.cpp images/optical_frames.cpp
  LINK fire3dv_build_info fire3dv_ros2_cameras fire3dv_ros2_tf CLI11::CLI11)
