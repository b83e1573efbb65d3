# Metrics page and its HTTP server.
if(TARGET fire3dv_metrics)
  fire3dv_test(metrics_test SOURCES app/metrics_test.cpp LINK fire3dv_metrics LABELS unit cpu)
endif()
