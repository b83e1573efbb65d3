# Skins, morph targets and animations.
if(TARGET fire3dv_state)
  fire3dv_test(scene_motion_test SOURCES scene/scene_skins_test.cpp scene/scene_motion_refuse_test.cpp
               LINK fire3dv_scene fire3dv_test_support LABELS unit)
  fire3dv_test(animation_test SOURCES scene/animation_test.cpp scene/animation_player_test.cpp scene/animation_assets_test.cpp
               LINK fire3dv_state fire3dv_test_support LABELS unit COLLECTION)
  target_compile_definitions(animation_test PRIVATE FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
endif()
