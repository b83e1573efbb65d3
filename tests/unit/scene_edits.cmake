if(TARGET fire3dv_state)
  fire3dv_test(edit_book_test SOURCES edit_book_test.cpp LINK fire3dv_state LABELS unit)
endif()
