# Budgets of peers.
fire3dv_test(peer_budget_test SOURCES state/peer_budget_test.cpp LINK fire3dv_base LABELS unit cpu)
target_compile_definitions(peer_budget_test PRIVATE FIRE3DV_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
