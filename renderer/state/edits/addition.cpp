#include "renderer/state/edits/addition.h"

#include "base/text.h"

namespace fire3dv::state {

std::string path_of(const std::string& name, const Addition& addition) {
  return (addition.parent.empty() ? "" : addition.parent + "/") + path_part(name);
}

bool is_at_or_below(std::string_view path, std::string_view top) {
  return path.starts_with(top) && (path.size() == top.size() || path[top.size()] == '/');
}

}  // namespace fire3dv::state
