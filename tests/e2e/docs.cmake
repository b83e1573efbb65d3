# Documents: links and anchors of all Markdown files, and the site that is built from them (tools/site.sh).
add_test(NAME docs_links COMMAND ${PROJECT_SOURCE_DIR}/tools/site.sh --links)
# Skipped without Debian's python3-myst-parser: it says so.
add_test(NAME site COMMAND ${PROJECT_SOURCE_DIR}/tools/site.sh --check)
set_tests_properties(docs_links site PROPERTIES LABELS e2e TIMEOUT 900 SKIP_RETURN_CODE 3)
