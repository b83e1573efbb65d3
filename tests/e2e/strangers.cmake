# Strangers at the renderer's ports, and the page of numbers that tells what became of them.
if(TARGET fire3dv)
  fire3dv_program(e2e_attacker SOURCES attacker.cpp LINK fire3dv_transport fire3dv_wire fire3dv_certificates)
  set_target_properties(e2e_attacker PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  fire3dv_e2e_test(metrics SCRIPT metrics_test.py PROGRAMS fire3dv e2e_publisher)
  fire3dv_e2e_test(attackers SCRIPT attackers_test.py PROGRAMS fire3dv e2e_publisher e2e_attacker)
endif()
