# Applicability of tests/mutations.txt: each mutation still changes the current source.
add_test(NAME mutations_apply COMMAND ${PROJECT_SOURCE_DIR}/tools/check_mutations.sh --applies)
set_tests_properties(mutations_apply PROPERTIES LABELS unit TIMEOUT 300)
