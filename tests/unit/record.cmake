# Recordings: the format, damage, and streams in them.
fire3dv_test(record_format_test SOURCES record_format_test.cpp LINK fire3dv_record LABELS unit)
target_compile_definitions(record_format_test PRIVATE FIRE3DV_RECORDINGS="${CMAKE_CURRENT_LIST_DIR}/recordings")
fire3dv_test(record_damage_test SOURCES record_damage_test.cpp LINK fire3dv_record LABELS unit)
fire3dv_test(record_stream_test SOURCES record_stream_test.cpp stream_log_test.cpp stream_player_test.cpp atomic_file_test.cpp
             record_losses_test.cpp
             LINK fire3dv_replay LABELS unit)
fire3dv_test(record_replay_test SOURCES replay_link_test.cpp record_foxglove_test.cpp LINK fire3dv_replay LABELS unit)
# Foxglove's messages are read by the code that flatc makes of their schemas.
target_include_directories(record_replay_test SYSTEM PRIVATE ${PROJECT_BINARY_DIR}/protocol/record/generated)
# An hour of 100 nodes at 1000 Hz: seeks take at most 50 ms, and 64 MB.
if(TARGET fire3dv-bench)
  add_test(NAME record_hour COMMAND python3 ${PROJECT_SOURCE_DIR}/tools/bench/recording.py --check --programs ${CMAKE_RUNTIME_OUTPUT_DIRECTORY})
  set_tests_properties(record_hour PROPERTIES LABELS long TIMEOUT 3600 ENVIRONMENT "PYTHONDONTWRITEBYTECODE=1")
endif()
