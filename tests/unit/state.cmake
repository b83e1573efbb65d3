if(TARGET fire3dv_state)
  fire3dv_test(state_test SOURCES state_binding_test.cpp state_frame_test.cpp state_playout_test.cpp state_schedule_test.cpp state_edits_test.cpp image_book_test.cpp image_turns_test.cpp LINK fire3dv_state LABELS unit)
endif()
