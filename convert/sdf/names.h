// Node names of SDF scenes, common to the converter and to publishers of Gazebo's poses, so that every name
// binds.
//
// A node is named by its entity's scoped name: the names of the models around it, of its link and its own,
// joined by '/', without the world. "robot/arm/wrist/visual" is a visual of link "wrist" in model "arm",
// which is nested in model "robot". '~' and '/' in the name of an entity are escaped as ~0 and ~1, as in
// SPEC.md's paths.
#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "base/text.h"

namespace fire3dv::convert {

// Order in which the entities of a scene take their names: all models, then all links, and so on; entities of
// one kind in the order of the file, parents before children.
enum class SdfEntity { model, link, visual, light, sensor };

inline const char* name_of(SdfEntity kind) {
  switch (kind) {
    case SdfEntity::model:
      return "model";
    case SdfEntity::link:
      return "link";
    case SdfEntity::visual:
      return "visual";
    case SdfEntity::light:
      return "light";
    case SdfEntity::sensor:
      break;
  }
  return "sensor";
}

// Name of an entity as a part of a scoped name. Control characters and invalid UTF-8 become '?'.
inline std::string escaped_sdf_name(std::string_view name) {
  return path_part(printable_text(name, std::string::npos));
}

// parent: scoped name; empty for entities of the world. An entity without a name has that of its kind.
inline std::string scoped_sdf_name(std::string_view parent, std::string_view name, SdfEntity kind) {
  const std::string part = escaped_sdf_name(name.empty() ? name_of(kind) : name);
  return parent.empty() ? part : std::string(parent) + "/" + part;
}

// Node of the glTF camera or light, which looks along -Z, below the node of its sensor or light: NAME#view,
// NAME#light. Its name is not in the stream: it moves with its parent.
inline std::string sdf_view_name(const std::string& node) {
  return node + "#view";
}
inline std::string sdf_light_name(const std::string& node) {
  return node + "#light";
}

// Unique names of the nodes of one scene. SDF wants siblings to have different names, Gazebo only those of
// one kind.
class SdfNames {
 public:
  // Returns the scoped name, or, if another entity has it, the first free one of "NAME light", "NAME light
  // 2", and so on, of at most 1024 bytes, the limit of a name in a stream.
  std::string take(const std::string& scoped_name, SdfEntity kind) {
    constexpr size_t kMaxBytes = 1024;
    std::string name = printable_text(scoped_name, kMaxBytes);
    if (taken_.insert(name).second) return name;
    // Files may have any number of equal names: the search goes on where the last one ended.
    unsigned& next = next_suffix_[{name, kind}];
    while (true) {
      const std::string suffix =
          std::string(" ") + name_of(kind) + (next > 0 ? " " + std::to_string(next + 1) : "");
      name = printable_text(scoped_name, kMaxBytes - suffix.size()) + suffix;
      ++next;
      if (taken_.insert(name).second) return name;
    }
  }

  // Frees the name of an entity that was removed.
  void release(const std::string& name) {
    taken_.erase(name);
    next_suffix_.clear();
  }

 private:
  std::set<std::string> taken_;
  std::map<std::pair<std::string, SdfEntity>, unsigned> next_suffix_;  // by name without suffix
};

}  // namespace fire3dv::convert
