# fire3dv doctor: broken set-ups, made by a driver that breaks on request, and by files, limits and mounts.
if(TARGET fire3dv)
  add_library(e2e_fake_driver MODULE doctor/fake_driver.c)
  target_include_directories(e2e_fake_driver PRIVATE ${Vulkan_INCLUDE_DIRS})
  add_library(e2e_fake_layer MODULE doctor/fake_layer.c)
  add_library(e2e_fake_cuda MODULE doctor/fake_cuda.c)
  set_target_properties(e2e_fake_driver e2e_fake_layer e2e_fake_cuda PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests PREFIX ""
                        C_VISIBILITY_PRESET hidden)
  add_test(NAME doctor COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/doctor/doctor_test.py $<TARGET_FILE:fire3dv>
           $<TARGET_FILE:e2e_fake_driver> $<TARGET_FILE:e2e_fake_layer> $<TARGET_FILE:e2e_fake_cuda>)
  set_tests_properties(doctor PROPERTIES LABELS e2e TIMEOUT 900
    ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1")
endif()
