#include "renderer/dataset/layouts/categories.h"

#include <algorithm>

#include "base/text.h"

namespace fire3dv::dataset {

Categories::Categories(const Description& description) : description_(description) {
  has_classes_ = std::any_of(description.instances.begin(), description.instances.end(),
                             [](const Instance& instance) { return instance.semantic != 0; });
  for (const Instance& instance : description.instances) {
    const uint32_t id = category_of(instance);
    if (id == 0) continue;
    Category& category = categories_[id];
    category.names.push_back(instance.name.empty() ? description.objects[instance.object].name
                                                   : instance.name);
    for (const Keypoint& point : description.keypoints) {
      auto& points = category.points;
      if (point.instance == instance.number &&
          std::find(points.begin(), points.end(), point.name) == points.end())
        points.push_back(point.name);
    }
  }
}

uint32_t Categories::category_of(const Instance& instance) const {
  return has_classes_ ? instance.semantic : description_.objects[instance.object].id;
}

std::vector<uint32_t> Categories::ids() const {
  std::vector<uint32_t> ids;
  for (const auto& [id, category] : categories_) ids.push_back(id);
  return ids;
}

std::string Categories::name_of(uint32_t category) const {
  const std::vector<std::string>& names = categories_.at(category).names;
  return printable_text(
      names.size() == 1 ? names.front() : (has_classes_ ? "class " : "object ") + std::to_string(category),
      200);
}

const std::vector<std::string>& Categories::points_of(uint32_t category) const {
  return categories_.at(category).points;
}

}  // namespace fire3dv::dataset
