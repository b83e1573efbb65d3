# Pose state.
if(TARGET fire3dv_state)
  fire3dv_test(state_test SOURCES state/frame_receiver_test.cpp state/scalar_history_test.cpp state/state_binding_test.cpp state/state_frame_test.cpp state/state_playout_test.cpp state/state_schedule_test.cpp state/state_edits_test.cpp state/image_requests_test.cpp state/image_scheduler_test.cpp state/robot_pose_test.cpp state/editing_test.cpp state/overlay_file_test.cpp LINK fire3dv_editing LABELS unit)
endif()
