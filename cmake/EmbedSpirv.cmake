# Generator of the embedded shaders: cmake -DOUTPUT=file.cpp "-DFILES=a.spv;b.spv" -P EmbedSpirv.cmake
#
# The output has the assembler include the SPIR-V files, which takes no time, and defines the functions of
# shaders/embedded.h. Its object depends on the SPIR-V files. Their digest is part of the text: compiler caches that hash
# sources and headers alone (ccache's depend mode) know no included binaries.
set(arrays "")
set(rows "")
set(index 0)
set(digests "")
foreach(file ${FILES})
  file(SHA256 ${file} digest)
  string(APPEND digests ${digest})
  get_filename_component(name ${file} NAME)
  string(REGEX REPLACE "\\.spv$" "" name ${name})
  string(APPEND arrays "asm(\".section .rodata\\n.balign 4\\n.globl fire3dv_spirv_${index}, fire3dv_spirv_end_${index}\\n\"
    \".hidden fire3dv_spirv_${index}, fire3dv_spirv_end_${index}\\n\"
    \"fire3dv_spirv_${index}: .incbin \\\"${file}\\\"\\nfire3dv_spirv_end_${index}:\\n.previous\");
extern \"C\" const uint32_t fire3dv_spirv_${index}[], fire3dv_spirv_end_${index}[];\n")
  string(APPEND rows "    {\"${name}\", fire3dv_spirv_${index}, fire3dv_spirv_end_${index}},\n")
  math(EXPR index "${index} + 1")
endforeach()
string(SHA256 digest "${digests}")
file(WRITE ${OUTPUT} "// Generated from the shaders by the build: ${digest}
#include \"shaders/embedded.h\"

${arrays}
namespace fire3dv::shaders {
namespace {
struct Entry { std::string_view name; const uint32_t* begin; const uint32_t* end; };
constexpr Entry entries[] = {
${rows}};
}  // namespace

std::span<const uint32_t> embedded(std::string_view name) {
  for (const Entry& entry : entries) if (entry.name == name) return {entry.begin, entry.end};
  return {};
}

std::vector<std::string_view> names() {
  std::vector<std::string_view> all;
  for (const Entry& entry : entries) all.push_back(entry.name);
  return all;
}

}  // namespace fire3dv::shaders
")
