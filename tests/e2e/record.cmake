# Recordings from end to end: recorder, player and inspector as programs, and a reader of MCAP in Python as the judge.
fire3dv_program(e2e_record_source SOURCES record_source.cpp LINK fire3dv_client)
set_target_properties(e2e_record_source PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
add_test(NAME record_programs
  COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/record_test.py $<TARGET_FILE:fire3dv-record> $<TARGET_FILE:fire3dv-replay>
          $<TARGET_FILE:fire3dv-inspect> $<TARGET_FILE:e2e_record_source>)
set_tests_properties(record_programs PROPERTIES LABELS e2e TIMEOUT 900 ENVIRONMENT "PYTHONDONTWRITEBYTECODE=1")
