# Robot description files through both programs: conversion, cache, streams and refusals.
if(TARGET fire3dv AND TARGET fire3dv-convert)
  find_program(FIRE3DV_PYTHON python3)
  set(descriptions_cases command_line kept without_cache unkept refused meshes sdf cameras passed_on)
  if(FIRE3DV_PYTHON AND NOT FIRE3DV_SANITIZE)  # Python cannot load a client with a sanitizer
    list(APPEND descriptions_cases moved recorded)
  endif()
  foreach(cases ${descriptions_cases})
    add_test(NAME convert_${cases}
      COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/convert_test.py $<TARGET_FILE:fire3dv> $<TARGET_FILE:fire3dv-convert> ${cases})
    set_tests_properties(convert_${cases} PROPERTIES LABELS e2e TIMEOUT 900
      ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1;PYTHONPATH=${PROJECT_SOURCE_DIR}/adapters/generic/python;FIRE3DV_CLIENT_LIBRARY=$<TARGET_FILE:fire3dv_client>")
  endforeach()
endif()
# Readers of all formats take time n log n.
if(TARGET fire3dv AND TARGET fire3dv-convert AND TARGET fire3dv-inspect AND NOT FIRE3DV_SANITIZE)
  add_test(NAME reader_times
    COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/convert/reader_times_test.py $<TARGET_FILE:fire3dv> $<TARGET_FILE:fire3dv-convert> $<TARGET_FILE:fire3dv-inspect>)
  set_tests_properties(reader_times PROPERTIES LABELS long RUN_SERIAL TRUE TIMEOUT 3600
    ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1")
endif()
