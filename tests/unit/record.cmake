# Recordings: the format, damage, and streams in them.
fire3dv_test(record_format_test SOURCES record_format_test.cpp LINK fire3dv_record LABELS unit)
fire3dv_test(record_damage_test SOURCES record_damage_test.cpp LINK fire3dv_record LABELS unit)
fire3dv_test(record_stream_test SOURCES record_stream_test.cpp LINK fire3dv_replayer LABELS unit)
