#include "renderer/scene/cache/record_text.h"

#include <istream>
#include <ostream>

namespace fire3dv::scene {

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\n')
      result += "\\n";
    else if (c == '\\')
      result += "\\\\";
    else
      result += c;
  }
  return result;
}

std::string unescaped(const std::string& text) {
  std::string result;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\' && i + 1 < text.size())
      result += text[++i] == 'n' ? '\n' : text[i];
    else
      result += text[i];
  }
  return result;
}

void write(std::ostream& out, const FileStamp& stamp) {
  out << stamp.exists << ' ' << stamp.size << ' ' << stamp.inode << ' ' << stamp.modified_ns << ' '
      << stamp.changed_ns;
}

bool read(std::istream& in, FileStamp& stamp) {
  return static_cast<bool>(in >> stamp.exists >> stamp.size >> stamp.inode >> stamp.modified_ns >>
                           stamp.changed_ns);
}

}  // namespace fire3dv::scene
