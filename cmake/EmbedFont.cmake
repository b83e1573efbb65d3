# Generator of the embedded font: cmake -DOUTPUT=file.cpp -DFILE=font.ttf -P EmbedFont.cmake
#
# The output defines the function of renderer/passes/markers/font.h.
file(READ ${FILE} hex HEX)
string(LENGTH "${hex}" digits)
math(EXPR bytes "${digits} / 2")
math(EXPR missing "(8 - ${digits} % 8) % 8")
string(REPEAT "0" ${missing} zeros)
string(APPEND hex "${zeros}")
# 32-bit words compile in a quarter of the time that bytes need. Little-endian, like all supported machines.
string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1," words "${hex}")
file(WRITE ${OUTPUT} "// Generated from a font by the build.
#include \"renderer/passes/markers/font.h\"

#include <bit>
#include <cstdint>

namespace fire3dv::passes {

static_assert(std::endian::native == std::endian::little);

std::span<const std::byte> font_bytes() {
  static constexpr uint32_t kWords[] = {${words}};
  return std::as_bytes(std::span(kWords)).first(${bytes});
}

}  // namespace fire3dv::passes
")
