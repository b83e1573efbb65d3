# Exported symbols of the AMBF plugin. AMBF loads all plugins into one global namespace, so the
# plugin must export its entry point only.
# cmake -D NM=nm -D LIBRARY=libfire3dv_ambf.so -P ambf_plugin_exports.cmake
execute_process(COMMAND ${NM} -D --defined-only ${LIBRARY} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]+" lines "${text}")
list(TRANSFORM lines REPLACE ".* " "")
if(NOT lines STREQUAL "CreatePlugin")
  message(FATAL_ERROR "${LIBRARY} exports\n  ${lines}\ninstead of\n  CreatePlugin")
endif()
