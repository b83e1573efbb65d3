# cmake -DSOURCE=dir -DOUTPUT=file.cpp -P commit.cmake
# Writes the commit's name as a constant; the file is left alone while the name stays, so that nothing is built anew.
set(commit "unknown")
execute_process(COMMAND git describe --always --dirty --abbrev=12 WORKING_DIRECTORY ${SOURCE}
                OUTPUT_VARIABLE described RESULT_VARIABLE result ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
# The checkout must be this tree, not one that this tree was unpacked into.
if(result EQUAL 0 AND EXISTS ${SOURCE}/.git)
  set(commit ${described})
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY NEWLINE_STYLE UNIX CONTENT
[[#include "tools/bench/build_info.h"

namespace fire3dv::bench {
const char* const kCommit = "@commit@";
}  // namespace fire3dv::bench
]])
