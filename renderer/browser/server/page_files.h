// Files of the page, embedded by the build (page_files.cpp is generated from renderer/browser/page).
#pragma once

#include <span>
#include <string_view>

namespace fire3dv::serve {

struct PageFile {
  std::string_view name;  // "main.js"
  std::string_view content;
};
std::span<const PageFile> page_files();

}  // namespace fire3dv::serve
