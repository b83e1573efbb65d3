# Gazebo adapter without a network.
if(TARGET fire3dv_gazebo_world)
  fire3dv_test(gazebo_discovery_test SOURCES gazebo/gazebo_discovery_test.cpp gazebo/gazebo_fields_test.cpp LINK fire3dv_gazebo_wire LABELS unit)
  fire3dv_test(gazebo_world_test SOURCES gazebo/gazebo_world_test.cpp gazebo/gazebo_scene_test.cpp
               LINK fire3dv_gazebo_world fire3dv_test_support LABELS unit)
  fire3dv_test(gazebo_cameras_test SOURCES gazebo/gazebo_cameras_test.cpp LINK fire3dv_gazebo_program LABELS unit)
endif()
