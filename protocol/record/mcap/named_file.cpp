#include "protocol/record/mcap/named_file.h"

#include <sys/stat.h>

#include "base/text.h"

namespace fire3dv::record {

Result<void> check_name_of(int fd, const std::string& path) {
  struct stat open {
  }, named{};
  if (::fstat(fd, &open) != 0) return {};  // unknown, not a fault of the file
  const bool has_name = ::stat(path.c_str(), &named) == 0;
  if (has_name && named.st_dev == open.st_dev && named.st_ino == open.st_ino) return {};
  const std::string file = terminal_text(path);
  if (open.st_nlink == 0)
    return Error{
        file + " was " + (has_name ? "replaced" : "removed") +
        " while it was written: what was written is lost; leave the file alone until the program ends"};
  return Error{file + (has_name ? " was moved and replaced" : " was moved") +
               " while it was written: what was written is in the moved file"};
}

}  // namespace fire3dv::record
