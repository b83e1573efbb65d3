if(TARGET fire3dv_state)
  fire3dv_test(scene_motion_test SOURCES scene_skins_test.cpp scene_motion_refuse_test.cpp
               LINK fire3dv_scene fire3dv_test_support LABELS unit)
  fire3dv_test(animation_test SOURCES animation_test.cpp animation_player_test.cpp animation_assets_test.cpp
               LINK fire3dv_state fire3dv_test_support LABELS unit)
  target_compile_definitions(animation_test PRIVATE FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endif()
