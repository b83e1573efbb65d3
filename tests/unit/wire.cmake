# Wire codec.
fire3dv_test(wire_test SOURCES state/wire_test.cpp allocation_count.cpp LINK fire3dv_wire LABELS unit cpu)
