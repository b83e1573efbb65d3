#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "renderer/dataset/layouts/categories.h"
#include "renderer/dataset/layouts/layouts.h"

namespace fire3dv::dataset {
namespace {

class YoloLayout final : public Layout {
 public:
  wire::ImageOutputs further_outputs() const override { return wire::ImageOutputs(0); }
  void prepare(const Description& description) override { categories_.emplace(description); }
  std::vector<std::string> folders(const Description& description) const override;
  std::string color_name(const Description& description, uint64_t image) const override;
  std::vector<std::string> file_names(const Description& description, uint64_t image,
                                      size_t instances) const override;
  Result<std::vector<std::vector<uint8_t>>> encode(const Description& description,
                                                   const sinks::FrameImage& image, const ImageLabels& labels,
                                                   std::vector<uint8_t> color) const override;
  Result<std::vector<offline::FolderFile>> list_files(const Description& description,
                                                      const offline::FrameLines& lines) const override;
  std::string conventions(const Description& description) const override;

 private:
  std::optional<Categories> categories_;
};

std::vector<std::string> YoloLayout::folders(const Description&) const {
  return {"images/train", "labels/train"};
}

std::string YoloLayout::color_name(const Description&, uint64_t image) const {
  return "images/train/" + six_digits(image) + ".png";
}

std::vector<std::string> YoloLayout::file_names(const Description& description, uint64_t image,
                                                size_t) const {
  return {color_name(description, image), "labels/train/" + six_digits(image) + ".txt"};
}

Result<std::vector<std::vector<uint8_t>>> YoloLayout::encode(const Description& description,
                                                             const sinks::FrameImage& image,
                                                             const ImageLabels& labels,
                                                             std::vector<uint8_t> color) const {
  const Categories& categories = categories_.value();
  const std::vector<uint32_t> ids = categories.ids();
  const double width = image.width, height = image.height;
  std::string text;
  for (const InstanceLabel& label : labels.instances) {
    const uint32_t category = categories.category_of(description.instances[label.index]);
    if (category == 0 || label.visible_px == 0) continue;
    const auto at = std::lower_bound(ids.begin(), ids.end(), category) - ids.begin();
    const Rectangle& box = label.visible_box;
    const auto left = static_cast<double>(box.left), top = static_cast<double>(box.top);
    const auto box_width = static_cast<double>(box.width), box_height = static_cast<double>(box.height);
    char line[128];
    std::snprintf(line, sizeof line, "%lld %.8f %.8f %.8f %.8f\n", static_cast<long long>(at),
                  (left + box_width / 2) / width, (top + box_height / 2) / height, box_width / width,
                  box_height / height);
    text += line;
  }
  std::vector<std::vector<uint8_t>> files;
  files.push_back(std::move(color));
  files.emplace_back(text.begin(), text.end());
  return files;
}

Result<std::vector<offline::FolderFile>> YoloLayout::list_files(const Description&,
                                                                const offline::FrameLines&) const {
  const Categories& categories = categories_.value();
  // Strings of JSON are strings of YAML.
  std::string text =
      "# Relative to this file. No images are held back: point val to others.\n"
      "train: images/train\nval: images/train\nnames:\n";
  size_t index = 0;
  for (const uint32_t id : categories.ids())
    text += "  " + std::to_string(index++) + ": " + nlohmann::json(categories.name_of(id)).dump() + "\n";
  std::vector<offline::FolderFile> files;
  files.push_back(text_file("data.yaml", text));
  return files;
}

std::string YoloLayout::conventions(const Description&) const {
  return R"(YOLO's layout for detection.

| file | contents |
|---|---|
| `images/train/IMAGE.png` | 8-bit colours, sRGB; images of one moment follow one another, camera by camera |
| `labels/train/IMAGE.txt` | for each visible instance: class, then x and y of the centre, width and height of its visible part, divided by the image's width and height; (0, 0) is the image's outer corner |
| `data.yaml` | folders, and the names of the classes from 0 |

- A class is a `semantic` in the extras of glTF nodes, in ascending order from 0; nodes without one are left
  out. In a scene without classes each object is a class.
- `val` in `data.yaml` names the training images: no images are held back. Point it to another data set.
)";
}

}  // namespace

std::unique_ptr<Layout> make_yolo_layout() {
  return std::make_unique<YoloLayout>();
}

}  // namespace fire3dv::dataset
