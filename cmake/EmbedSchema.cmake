# Generator of an embedded schema: cmake -DOUTPUT=file.cpp -DFILE=schema.bfbs -DFUNCTION=name -P EmbedSchema.cmake
#
# The output defines FUNCTION of protocol/record/channels.h.
file(READ ${FILE} hex HEX)
string(REGEX REPLACE "(..)" "0x\\1," bytes "${hex}")
file(WRITE ${OUTPUT} "// Generated from the schema by the build.
#include \"protocol/record/channels.h\"

namespace fire3dv::record {

std::span<const std::byte> ${FUNCTION}() {
  static constexpr unsigned char kBytes[] = {${bytes}};
  return std::as_bytes(std::span(kBytes));
}

}  // namespace fire3dv::record
")
