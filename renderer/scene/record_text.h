// Records of files, as lines of text.
#pragma once

#include <iosfwd>
#include <string>

#include "renderer/scene/file_stamp.h"

namespace fire3dv::scene {

// A name as one line, and back.
std::string escaped(const std::string& text);
std::string unescaped(const std::string& text);

// Numbers with spaces between them. False: what is there is no stamp.
void write(std::ostream& out, const FileStamp& stamp);
bool read(std::istream& in, FileStamp& stamp);

}  // namespace fire3dv::scene
