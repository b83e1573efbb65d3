# Robots by joint positions.
fire3dv_test(robot_test SOURCES robot/robot_test.cpp robot/robot_file_test.cpp LINK fire3dv::client
             LABELS unit cpu)
