# Generator of the embedded shaders: cmake -DOUTPUT=file.cpp "-DFILES=a.spv;b.spv" -P EmbedSpirv.cmake
#
# The output defines SPIR-V word arrays and the functions of shaders/embedded.h.
set(arrays "")
set(rows "")
set(index 0)
foreach(file ${FILES})
  get_filename_component(name ${file} NAME)
  string(REGEX REPLACE "\\.spv$" "" name ${name})
  file(READ ${file} hex HEX)
  # Files store little-endian bytes; hexadecimal literals start with the most significant byte.
  string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1," words "${hex}")
  string(APPEND arrays "constexpr uint32_t code_${index}[] = {${words}};\n")
  string(APPEND rows "    {\"${name}\", code_${index}},\n")
  math(EXPR index "${index} + 1")
endforeach()
file(WRITE ${OUTPUT} "// Generated from the shaders by the build.
#include \"shaders/embedded.h\"

namespace fire3dv::shaders {
namespace {
${arrays}
struct Entry { std::string_view name; std::span<const uint32_t> code; };
constexpr Entry entries[] = {
${rows}};
}  // namespace

std::span<const uint32_t> embedded(std::string_view name) {
  for (const Entry& entry : entries) if (entry.name == name) return entry.code;
  return {};
}

std::vector<std::string_view> names() {
  std::vector<std::string_view> all;
  for (const Entry& entry : entries) all.push_back(entry.name);
  return all;
}

}  // namespace fire3dv::shaders
")
