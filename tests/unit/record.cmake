# Recordings: format, damage, and streams.
fire3dv_test(record_format_test SOURCES record/record_format_test.cpp LINK fire3dv_record LABELS unit)
target_compile_definitions(record_format_test PRIVATE FIRE3DV_RECORDINGS="${CMAKE_CURRENT_LIST_DIR}/recordings")
fire3dv_test(record_damage_test SOURCES record/record_damage_test.cpp LINK fire3dv_record LABELS unit)
fire3dv_test(record_stream_test SOURCES record/record_stream_test.cpp record/stream_log_test.cpp record/stream_player_test.cpp record/atomic_file_test.cpp
             record/record_losses_test.cpp
             LINK fire3dv_replay LABELS unit)
fire3dv_test(record_replay_test SOURCES record/replay_link_test.cpp record/record_foxglove_test.cpp record/record_foxglove_markers_test.cpp LINK fire3dv_replay LABELS unit)
fire3dv_test(replay_links_test SOURCES record/replay_links_test.cpp transport/network_namespace.cpp
             LINK fire3dv_replay fire3dv_state fire3dv_certificates LABELS unit)
# The test reads Foxglove's messages with the code that flatc generates from their schemas.
target_include_directories(record_replay_test SYSTEM PRIVATE ${PROJECT_BINARY_DIR}/protocol/record/generated)
# One hour of 100 nodes at 1000 Hz: seeks take at most 50 ms, and 64 MB.
if(TARGET fire3dv-bench)
  add_test(NAME record_hour COMMAND python3 ${PROJECT_SOURCE_DIR}/tools/lab/bench/scripts/recording.py --check --programs ${CMAKE_RUNTIME_OUTPUT_DIRECTORY})
  set_tests_properties(record_hour PROPERTIES LABELS long TIMEOUT 3600 ENVIRONMENT "PYTHONDONTWRITEBYTECODE=1")
endif()
