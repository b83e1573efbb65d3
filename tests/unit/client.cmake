# C and C++ client library.
fire3dv_test(client_test SOURCES adapters/client_test.cpp
  LINK fire3dv::client fire3dv_wire fire3dv_transport LABELS unit cpu)
fire3dv_test(client_image_test SOURCES adapters/client_image_test.cpp
  LINK fire3dv::client fire3dv_wire fire3dv_transport LABELS unit cpu)
fire3dv_test(client_hpp_test SOURCES adapters/client_hpp_test.cpp
  LINK fire3dv::client fire3dv_wire fire3dv_transport LABELS unit cpu)
fire3dv_test(client_hot_path_test SOURCES adapters/client_hot_path_test.cpp allocation_count.cpp
  LINK fire3dv::client LABELS unit cpu)

# The library exports its C functions only.
add_test(NAME client_exports
  COMMAND ${CMAKE_COMMAND} -D NM=${CMAKE_NM} -D LIBRARY=$<TARGET_FILE:fire3dv_client>
          -P ${CMAKE_CURRENT_SOURCE_DIR}/scripts/client_exports.cmake)
set_tests_properties(client_exports PROPERTIES LABELS "unit;cpu" TIMEOUT 60)
