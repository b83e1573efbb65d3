// Text encoding of file records: names and stamps.
#pragma once

#include <iosfwd>
#include <string>

#include "renderer/scene/cache/file_stamp.h"

namespace fire3dv::scene {

// Escapes a name to one line, and back.
std::string escaped(const std::string& text);
std::string unescaped(const std::string& text);

// Space-separated integers. read() returns false for invalid input.
void write(std::ostream& out, const FileStamp& stamp);
bool read(std::istream& in, FileStamp& stamp);

}  // namespace fire3dv::scene
