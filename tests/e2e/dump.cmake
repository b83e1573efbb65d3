# Stream inspection program that several tests share.
fire3dv_program(stream_dump SOURCES programs/stream_dump.cpp ${PROJECT_SOURCE_DIR}/tests/conformance/json_message.cpp
  ${PROJECT_SOURCE_DIR}/tests/conformance/json_edit.cpp ${PROJECT_SOURCE_DIR}/tests/conformance/json_image.cpp
  LINK fire3dv_wire fire3dv_transport)
set_target_properties(stream_dump PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
