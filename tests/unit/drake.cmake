# Requests of Drake's render client.
if(TARGET fire3dv_drake_request)
  fire3dv_test(drake_request_test SOURCES adapters/drake_multipart_test.cpp adapters/drake_request_test.cpp
               LINK fire3dv_drake_request LABELS unit)
  fire3dv_test(drake_server_test SOURCES adapters/drake_server_test.cpp LINK fire3dv_drake_http LABELS unit)
endif()
