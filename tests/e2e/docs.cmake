# Documents: links and anchors of all Markdown files, and the site that is built from them (tools/site.sh).
add_test(NAME docs_links COMMAND ${PROJECT_SOURCE_DIR}/tools/site.sh --links)
# Skipped without Debian's python3-myst-parser: it says so.
add_test(NAME site COMMAND ${PROJECT_SOURCE_DIR}/tools/site.sh --check)
set_tests_properties(docs_links site PROPERTIES LABELS e2e TIMEOUT 900 SKIP_RETURN_CODE 3)

# Tutorials: their commands as they stand in the Markdown file, and their pictures.
if(TARGET fire3dv AND TARGET fire3dv-convert AND NOT FIRE3DV_SANITIZE)  # Python cannot load a client with a sanitizer
  include(${PROJECT_SOURCE_DIR}/cmake/PythonWithNumpy.cmake)
  set(tutorials python c dataset ambf)
  if(TARGET fire3dv-mujoco)
    list(APPEND tutorials mujoco)
  endif()
  if(TARGET fire3dv-ros2)
    list(APPEND tutorials ros2)
  endif()
  foreach(tutorial ${tutorials})
    set(before "")
    set(stand_ins "")
    if(tutorial STREQUAL "ros2")
      set(before --own-network)
      set(stand_ins ${CMAKE_CURRENT_LIST_DIR}/docs/ros2_stand_in.py ${PROJECT_BINARY_DIR}/tests/e2e_cyclone_publisher)
    endif()
    add_test(NAME tutorial_${tutorial}
      COMMAND ${FIRE3DV_NUMPY_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/docs/tutorials_test.py ${before}
              ${PROJECT_SOURCE_DIR}/docs/tutorials/${tutorial}.md ${PROJECT_BINARY_DIR} ${stand_ins})
    set_tests_properties(tutorial_${tutorial} PROPERTIES LABELS e2e TIMEOUT 900 SKIP_RETURN_CODE 77
      ENVIRONMENT "VK_DRIVER_FILES=${FIRE3DV_TEST_VULKAN_DRIVER};VK_ICD_FILENAMES=${FIRE3DV_TEST_VULKAN_DRIVER};PYTHONDONTWRITEBYTECODE=1;PYTHONPATH=${PROJECT_SOURCE_DIR}/adapters/generic/python;FIRE3DV_CLIENT_LIBRARY=$<TARGET_FILE:fire3dv_client>")
  endforeach()
endif()
