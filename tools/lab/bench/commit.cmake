# Generator of commit.cpp: cmake -DSOURCE=dir -DOUTPUT=file.cpp -P commit.cmake. The file is rewritten only when the
# commit changes, so that nothing is rebuilt needlessly.
set(commit "unknown")
execute_process(COMMAND git describe --always --dirty --abbrev=12 WORKING_DIRECTORY ${SOURCE}
                OUTPUT_VARIABLE described RESULT_VARIABLE result ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
# Only a checkout of this tree counts, not an outer repository that contains an unpacked copy.
if(result EQUAL 0 AND EXISTS ${SOURCE}/.git)
  set(commit ${described})
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY NEWLINE_STYLE UNIX CONTENT
[[#include "tools/lab/bench/report/build_info.h"

namespace fire3dv::bench {
const char* const kCommit = "@commit@";
}  // namespace fire3dv::bench
]])
