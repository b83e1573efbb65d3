# Requests of Drake's render client.
if(TARGET fire3dv_drake_request)
  fire3dv_test(drake_request_test SOURCES adapters/drake_multipart_test.cpp adapters/drake_request_test.cpp
               LINK fire3dv_drake_request LABELS unit)
endif()
