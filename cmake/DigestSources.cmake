# Digest header of source files: cmake -DOUTPUT=file.h "-DFILES=a.cpp;b.h" -DMORE=text -P DigestSources.cmake
#
# The header defines one SHA-256 digest of all files and MORE, for cache keys that must change with the code.
set(all "${MORE}")
foreach(file ${FILES})
  file(SHA256 ${file} digest)
  string(APPEND all "${digest}")
endforeach()
string(SHA256 digest "${all}")
set(text "#pragma once\n#define FIRE3DV_SCENE_SOURCES \"${digest}\"\n")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} known)
endif()
if(NOT "${known}" STREQUAL "${text}")
  file(WRITE ${OUTPUT} "${text}")
endif()
