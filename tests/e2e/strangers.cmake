# Untrusted peers at the renderer's ports, and the metrics page that counts them.
if(TARGET fire3dv)
  fire3dv_program(e2e_attacker SOURCES programs/attacker.cpp LINK fire3dv_transport fire3dv_wire fire3dv_certificates)
  set_target_properties(e2e_attacker PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  fire3dv_e2e_test(metrics SCRIPT metrics_test.py PROGRAMS fire3dv e2e_publisher)
  fire3dv_e2e_test(attackers SCRIPT links/attackers_test.py PROGRAMS fire3dv e2e_publisher e2e_attacker)
endif()

# One peer against the others: each attack runs beside an honest adapter, whose images are counted.
if(TARGET fire3dv AND NOT FIRE3DV_SANITIZE)
  fire3dv_program(e2e_greedy_peer SOURCES programs/greedy_peer.cpp programs/greedy_attacks.cpp programs/raw_peer.cpp programs/raw_udp.cpp programs/colliding_names.cpp
                  LINK fire3dv_client_inside fire3dv_transport fire3dv_wire)
  set_target_properties(e2e_greedy_peer PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  fire3dv_e2e_test(greedy_peers SCRIPT links/greedy_peers_test.py PROGRAMS fire3dv e2e_greedy_peer)
  set_tests_properties(greedy_peers PROPERTIES RUN_SERIAL TRUE)  # compares rates within one run
  # An hour: FIRE3DV_SOAK_MINUTES=60 ctest --preset ci -R '^soak$' -V
  fire3dv_e2e_test(soak SCRIPT links/soak_test.py PROGRAMS fire3dv fire3dv-inspect e2e_greedy_peer e2e_record_source)
  set_tests_properties(soak PROPERTIES LABELS long RUN_SERIAL TRUE TIMEOUT 7200)
endif()
