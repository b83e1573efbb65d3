// Categories of formats for detection: classes of the scene, or the objects themselves if it has none.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "renderer/dataset/labels/description.h"

namespace fire3dv::dataset {

// Borrows the description.
class Categories {
 public:
  explicit Categories(const Description& description);

  // 0: not annotated.
  uint32_t category_of(const Instance& instance) const;
  std::vector<uint32_t> ids() const;  // ascending
  // Printable. A class of several bodies has no name in the scene.
  std::string name_of(uint32_t category) const;
  // Names of the keypoints of a category, in the order of annotations.
  const std::vector<std::string>& points_of(uint32_t category) const;

 private:
  struct Category {
    std::vector<std::string> names, points;
  };
  const Description& description_;
  bool has_classes_ = false;
  std::map<uint32_t, Category> categories_;
};

}  // namespace fire3dv::dataset
