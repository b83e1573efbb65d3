# Tests of fire3dv-mujoco: commands of its README, control by lines, images, and refusals.
if(TARGET fire3dv AND TARGET fire3dv-mujoco AND TARGET stream_dump)
  foreach(cases commands drawn images hands refused)
    add_test(NAME mujoco_${cases}
      COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/mujoco_test.py $<TARGET_FILE:fire3dv> $<TARGET_FILE:fire3dv-mujoco>
              $<TARGET_FILE:stream_dump> ${cases})
    set_tests_properties(mujoco_${cases} PROPERTIES LABELS e2e TIMEOUT 900
      ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1")
  endforeach()
endif()

# Comparison with MuJoCo's own renderer; needs OpenGL.
if(TARGET fire3dv AND TARGET fire3dv-mujoco-compare)
  add_test(NAME mujoco_compare
    COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/mujoco_compare_test.py $<TARGET_FILE:fire3dv> $<TARGET_FILE:fire3dv-mujoco>
            $<TARGET_FILE:fire3dv-mujoco-compare>)
  set_tests_properties(mujoco_compare PROPERTIES LABELS e2e TIMEOUT 900 SKIP_RETURN_CODE 77
    ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1")
endif()
