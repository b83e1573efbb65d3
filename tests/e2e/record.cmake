# Recordings from end to end: recorder, player and inspector as programs, with a Python MCAP reader
# as the oracle.
fire3dv_program(e2e_record_source SOURCES programs/record_source.cpp LINK fire3dv_client)
set_target_properties(e2e_record_source PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
add_test(NAME record_programs
  COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/record/record_test.py $<TARGET_FILE:fire3dv-record> $<TARGET_FILE:fire3dv-replay>
          $<TARGET_FILE:fire3dv-inspect> $<TARGET_FILE:e2e_record_source>)
set_tests_properties(record_programs PROPERTIES LABELS e2e TIMEOUT 900 ENVIRONMENT "PYTHONDONTWRITEBYTECODE=1")

# External oracle. The build does not fetch its npm packages: the test exists where this variable
# names them.
set(FIRE3DV_MCAP_NODE_MODULES "$ENV{FIRE3DV_MCAP_NODE_MODULES}" CACHE PATH
    "node_modules folder with @mcap/core, @mcap/support, @mcap/nodejs, flatbuffers, flatbuffers_reflection; empty: mcap_oracle is left out")
fire3dv_program(e2e_record_sample SOURCES programs/record_sample.cpp LINK fire3dv_record)
set_target_properties(e2e_record_sample PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
if(FIRE3DV_MCAP_NODE_MODULES)
  add_test(NAME mcap_oracle
    COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/record/mcap_oracle_test.py ${FIRE3DV_MCAP_NODE_MODULES} $<TARGET_FILE:e2e_record_sample>
            $<TARGET_FILE:fire3dv-inspect> $<TARGET_FILE:fire3dv-record>)
  set_tests_properties(mcap_oracle PROPERTIES LABELS e2e TIMEOUT 300 ENVIRONMENT "PYTHONDONTWRITEBYTECODE=1")
endif()

# Power cuts: a preloaded library keeps a journal of file operations. Sanitizers must be loaded
# first, so sanitizer builds leave these tests out.
if(NOT FIRE3DV_SANITIZE)
  add_library(lose_unsynced MODULE programs/file_operation_journal.c)
  target_link_libraries(lose_unsynced PRIVATE fire3dv_flags)
  fire3dv_program(e2e_power_cut_writer SOURCES programs/power_cut_writer.cpp LINK fire3dv_record)
  set_target_properties(lose_unsynced e2e_power_cut_writer PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  foreach(test_cuts_label power_cut:20:e2e power_cut_long:200:long)
    string(REPLACE ":" ";" parts ${test_cuts_label})
    list(GET parts 0 name)
    list(GET parts 1 cuts)
    list(GET parts 2 label)
    add_test(NAME ${name}
      COMMAND python3 ${CMAKE_CURRENT_LIST_DIR}/record/power_cut_test.py $<TARGET_FILE:fire3dv-record> $<TARGET_FILE:e2e_record_source>
              $<TARGET_FILE:e2e_power_cut_writer> $<TARGET_FILE:lose_unsynced>)
    set_tests_properties(${name} PROPERTIES LABELS ${label} TIMEOUT 900
                         ENVIRONMENT "PYTHONDONTWRITEBYTECODE=1;FIRE3DV_POWER_CUTS=${cuts}")
  endforeach()
endif()
