# Score of interpolated motion.
if(TARGET fire3dv_motion_score)
  fire3dv_test(motion_score_test SOURCES app/motion_score_test.cpp LINK fire3dv_motion_score fire3dv_impair LABELS unit)
endif()
