if(TARGET fire3dv_metrics)
  fire3dv_test(metrics_test SOURCES metrics_test.cpp LINK fire3dv_metrics LABELS unit cpu)
endif()
