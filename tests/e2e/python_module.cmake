# The Python module against the library of this build. An interpreter that was not built with a sanitizer cannot load a
# library that was.
find_program(FIRE3DV_PYTHON python3)
if(FIRE3DV_PYTHON AND NOT FIRE3DV_SANITIZE)
  fire3dv_program(stream_dump SOURCES stream_dump.cpp ${PROJECT_SOURCE_DIR}/tests/conformance/json_message.cpp
    ${PROJECT_SOURCE_DIR}/tests/conformance/json_edit.cpp ${PROJECT_SOURCE_DIR}/tests/conformance/json_image.cpp
    LINK fire3dv_wire fire3dv_transport)
  set_target_properties(stream_dump PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  foreach(scheme shm tcp)
    add_test(NAME python_module_${scheme}
      COMMAND ${FIRE3DV_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python_module_test.py $<TARGET_FILE:stream_dump> ${scheme})
    set_tests_properties(python_module_${scheme} PROPERTIES LABELS "e2e;cpu" TIMEOUT 300
      ENVIRONMENT "PYTHONPATH=${PROJECT_SOURCE_DIR}/adapters/generic/python;PYTHONDONTWRITEBYTECODE=1;FIRE3DV_CLIENT_LIBRARY=$<TARGET_FILE:fire3dv_client>")
  endforeach()
endif()
