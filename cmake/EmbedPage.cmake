# Generator of the embedded page: cmake -DOUTPUT=file.cpp "-DFILES=a.html;b.js" -P EmbedPage.cmake
#
# The output defines the function of renderer/browser/server/page_files.h. The files are text.
set(entries "")
set(arrays "")
set(number 0)
foreach(file ${FILES})
  get_filename_component(name ${file} NAME)
  file(READ ${file} hex HEX)
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${hex}")
  string(APPEND arrays "constexpr unsigned char kFile${number}[] = {${bytes}};\n")
  string(APPEND entries "    {\"${name}\", text(kFile${number})},\n")
  math(EXPR number "${number} + 1")
endforeach()
file(WRITE ${OUTPUT} "// Generated from the files of the page by the build.
#include \"renderer/browser/server/page_files.h\"

#include <array>
#include <cstddef>

namespace fire3dv::serve {
namespace {

${arrays}
template <size_t size>
std::string_view text(const unsigned char (&bytes)[size]) {
  return {reinterpret_cast<const char*>(bytes), size};
}

}  // namespace

std::span<const PageFile> page_files() {
  static const std::array<PageFile, ${number}> files{{
${entries}  }};
  return files;
}

}  // namespace fire3dv::serve
")
