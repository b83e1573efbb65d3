# Links: shared memory, TCP, TLS, UDP.
fire3dv_test(transport_uri_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/uri_test.cpp
             LINK fire3dv_transport LABELS unit)
fire3dv_test(transport_shm_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/shm_test.cpp
             LINK fire3dv_transport LABELS unit)
fire3dv_test(transport_network_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/network_test.cpp
             LINK fire3dv_transport fire3dv_certificates LABELS unit)
fire3dv_test(transport_shm_crash_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/shm_crash_test.cpp
             LINK fire3dv_transport LABELS unit)
fire3dv_test(transport_shm_hostile_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/shm_hostile_test.cpp
             LINK fire3dv_transport LABELS unit)
fire3dv_test(transport_network_hostile_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/network_hostile_test.cpp
             LINK fire3dv_transport LABELS unit)
fire3dv_test(transport_udp_parts_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/udp/udp_parts_test.cpp
             LINK fire3dv_transport LABELS unit)
fire3dv_test(transport_udp_newest_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/udp/udp_newest_test.cpp
             LINK fire3dv_transport fire3dv_impair LABELS unit)
fire3dv_test(transport_memory_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/memory_test.cpp ${CMAKE_CURRENT_LIST_DIR}/transport/allocation_fault.cpp
                     ${CMAKE_CURRENT_LIST_DIR}/transport/inbox_test.cpp
             LINK fire3dv_transport LABELS unit)
fire3dv_test(transport_tls_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/tls_test.cpp
             LINK fire3dv_transport fire3dv_certificates LABELS unit)
fire3dv_test(transport_udp_key_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/udp/udp_key_test.cpp
                     ${CMAKE_CURRENT_LIST_DIR}/transport/udp/udp_attack_test.cpp
             LINK fire3dv_transport fire3dv_certificates fire3dv_impair LABELS unit)
fire3dv_test(transport_udp_sealed_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/udp/udp_sealed_test.cpp allocation_count.cpp
             LINK fire3dv_transport fire3dv_certificates LABELS unit)
fire3dv_test(transport_shm_model_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/ring_model_test.cpp
             LINK fire3dv_transport LABELS unit)
fire3dv_test(transport_shm_steps_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/shm_steps_test.cpp
             LINK fire3dv_transport LABELS unit)
fire3dv_test(transport_udp_mtu_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/udp/udp_mtu_test.cpp
             LINK fire3dv_transport fire3dv_certificates fire3dv_impair LABELS unit)
fire3dv_test(transport_udp_group_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/udp/udp_carousel_test.cpp ${CMAKE_CURRENT_LIST_DIR}/transport/udp/udp_group_test.cpp
                     ${CMAKE_CURRENT_LIST_DIR}/transport/link_local_test.cpp ${CMAKE_CURRENT_LIST_DIR}/transport/network_namespace.cpp
             LINK fire3dv_transport fire3dv_certificates LABELS unit)
fire3dv_test(transport_impair_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/impair_test.cpp
             LINK fire3dv_impair LABELS unit)
fire3dv_test(transport_images_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/images_test.cpp
             LINK fire3dv_transport LABELS unit)
