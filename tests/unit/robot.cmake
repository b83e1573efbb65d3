# Robots by joint positions: the client's forward kinematics, and the joints that the converter writes.
fire3dv_test(robot_test SOURCES robot/robot_test.cpp robot/robot_file_test.cpp LINK fire3dv::client
             LABELS unit cpu)
fire3dv_test(robot_hpp_test SOURCES robot/robot_hpp_test.cpp
             LINK fire3dv::client fire3dv_wire fire3dv_transport LABELS unit cpu)
if(TARGET fire3dv_descriptions)
  fire3dv_test(robot_joints_test SOURCES robot/robot_joints_test.cpp
               LINK fire3dv::client fire3dv_descriptions fire3dv_test_support LABELS unit cpu)
  # Oracles: MuJoCo and KDL, where they are installed, and Bullet.
  if(TARGET fire3dv_mujoco_compiled)
    fire3dv_test(robot_mujoco_test SOURCES robot/robot_mujoco_test.cpp
                 LINK fire3dv_robot fire3dv::client fire3dv_mujoco_compiled fire3dv_descriptions fire3dv_test_support LABELS unit COLLECTION)
    target_compile_definitions(robot_mujoco_test PRIVATE FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  endif()
  find_package(PkgConfig REQUIRED)
  if(TARGET fire3dv_adf)
    pkg_check_modules(bullet_oracle REQUIRED IMPORTED_TARGET bullet)
    fire3dv_test(robot_adf_test SOURCES robot/robot_adf_test.cpp
                 LINK fire3dv::client fire3dv_descriptions fire3dv_test_support PkgConfig::bullet_oracle LABELS unit cpu)
  endif()
  pkg_check_modules(urdfdom REQUIRED IMPORTED_TARGET urdfdom)
  pkg_check_modules(kdl QUIET IMPORTED_TARGET orocos-kdl)
  if(TARGET PkgConfig::kdl)
    fire3dv_test(robot_kdl_test SOURCES robot/robot_kdl_test.cpp
                 LINK fire3dv::client fire3dv_descriptions fire3dv_test_support PkgConfig::urdfdom PkgConfig::kdl
                 LABELS unit cpu)
  endif()
endif()
