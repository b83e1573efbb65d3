# Scene edits: store, links, client.
fire3dv_test(edit_store_test SOURCES state/edit_store_test.cpp LINK fire3dv_wire LABELS unit cpu)
fire3dv_test(transport_states_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/transport/states_test.cpp
             LINK fire3dv_transport LABELS unit)
fire3dv_test(client_scalars_test SOURCES adapters/client_scalars_test.cpp
  LINK fire3dv::client fire3dv_wire fire3dv_transport LABELS unit cpu)
fire3dv_test(client_scene_test SOURCES adapters/client_scene_test.cpp
  LINK fire3dv::client fire3dv_wire fire3dv_transport LABELS unit cpu)
if(TARGET fire3dv_state)
  fire3dv_test(edits_property_test SOURCES state/edits_property_test.cpp
    LINK fire3dv::client fire3dv_wire fire3dv_transport fire3dv_state fire3dv_impair LABELS unit)
endif()
