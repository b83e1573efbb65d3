# Render server for Drake.
if(TARGET fire3dv AND TARGET fire3dv-drake)
  foreach(cases depth labels colors parallel hostile cached independent command)
    add_test(NAME drake_${cases} COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/drake_test.py $<TARGET_FILE:fire3dv>
             $<TARGET_FILE:fire3dv-drake> ${cases})
    set_tests_properties(drake_${cases} PROPERTIES LABELS e2e TIMEOUT 900
      ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1")
  endforeach()
endif()
