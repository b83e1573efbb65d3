# Strangers at the renderer's ports, and the page of numbers that tells what became of them.
if(TARGET fire3dv)
  fire3dv_e2e_test(metrics SCRIPT metrics_test.py PROGRAMS fire3dv e2e_publisher)
endif()
