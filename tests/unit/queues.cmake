# Selection of queues, and submissions to several.
if(TARGET fire3dv_gpu)
  foreach(subject queue_choice forked_submit)
    fire3dv_test(${subject}_test SOURCES drawing/${subject}_test.cpp LINK fire3dv_gpu LABELS unit)
  endforeach()
endif()
