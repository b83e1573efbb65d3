# Example soft_tissue: vertices and poses of one frame in each image, while the tissue is cut.
if(TARGET fire3dv AND TARGET soft_tissue)
  add_test(NAME soft_tissue
    COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/bullet_arm/soft_tissue_test.py $<TARGET_FILE:fire3dv> $<TARGET_FILE:soft_tissue>)
  set_tests_properties(soft_tissue PROPERTIES LABELS e2e TIMEOUT 900
    ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1")
endif()
