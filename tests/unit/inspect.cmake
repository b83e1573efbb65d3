# Stream inspection.
fire3dv_test(inspect_test SOURCES app/inspect_test.cpp LINK fire3dv_observer LABELS unit)
