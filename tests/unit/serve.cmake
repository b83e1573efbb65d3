# Live view in the browser: access, messages, JPEG, and the server against a client of plain sockets.
if(TARGET fire3dv_serve)
  fire3dv_test(serve_test SOURCES serve/access_test.cpp serve/adaptive_quality_test.cpp serve/message_test.cpp serve/server_test.cpp
               LINK fire3dv_serve LABELS unit cpu)
endif()
