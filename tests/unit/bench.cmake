# Benchmark components: statistics, scenes, and reports.
if(TARGET fire3dv_bench_frames)
  foreach(part report scene)
    fire3dv_test(bench_${part}_test SOURCES app/bench_${part}_test.cpp LINK fire3dv_bench_frames LABELS unit)
  endforeach()
endif()
