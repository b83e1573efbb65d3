#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "base/text.h"
#include "renderer/dataset/layouts/categories.h"
#include "renderer/dataset/layouts/layouts.h"

namespace fire3dv::dataset {
namespace {

using nlohmann::ordered_json;

ordered_json categories_json(const Categories& categories) {
  ordered_json list = ordered_json::array();
  for (const uint32_t id : categories.ids()) {
    ordered_json each;
    each["id"] = id;
    each["name"] = categories.name_of(id);
    each["supercategory"] = "";
    if (const std::vector<std::string>& points = categories.points_of(id); !points.empty()) {
      each["keypoints"] = ordered_json::array();
      for (const std::string& name : points) each["keypoints"].push_back(printable_text(name, 200));
      each["skeleton"] = ordered_json::array();
    }
    list.push_back(std::move(each));
  }
  return list;
}

// Keypoints of a line by instance and name.
using Points = std::map<std::pair<uint32_t, std::string>, const ordered_json*>;
Points find_points(const ordered_json& line) {
  Points points;
  for (const ordered_json& point : line.at("keypoints"))
    points.try_emplace({point.at("instance").get<uint32_t>(), point.at("name").get<std::string>()}, &point);
  return points;
}

// x, y and 2 (visible), 1 (hidden) or 0 (outside) of each point.
void add_keypoints(const Points& points, uint32_t instance, const std::vector<std::string>& names,
                   ordered_json& annotation) {
  if (names.empty()) return;
  ordered_json values = ordered_json::array();
  uint64_t labelled = 0;
  for (const std::string& name : names) {
    ordered_json triple = {0, 0, 0};
    const auto found = points.find({instance, name});
    if (found != points.end() && found->second->at("state") != "outside") {
      const ordered_json& pixel = found->second->at("pixel");
      triple = {pixel.at(0), pixel.at(1), found->second->at("state") == "visible" ? 2 : 1};
      ++labelled;
    }
    values.insert(values.end(), triple.begin(), triple.end());
  }
  annotation["keypoints"] = std::move(values);
  annotation["num_keypoints"] = labelled;
}

// One element a line: lists of data sets are long.
std::string json_list(const std::vector<std::string>& elements) {
  std::string text = "[";
  for (const std::string& element : elements) text += (text.size() > 1 ? ",\n" : "\n") + element;
  return text + "\n]";
}

class CocoLayout final : public Layout {
 public:
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

std::vector<std::string> CocoLayout::folders(const Description&) const {
  return {"images"};
}

std::string CocoLayout::color_name(const Description&, uint64_t image) const {
  return "images/" + six_digits(image) + ".png";
}

std::vector<std::string> CocoLayout::file_names(const Description& description, uint64_t image,
                                                size_t) const {
  return {color_name(description, image)};
}

Result<std::vector<std::vector<uint8_t>>> CocoLayout::encode(const Description&, const sinks::FrameImage&,
                                                             const ImageLabels&,
                                                             std::vector<uint8_t> color) const {
  std::vector<std::vector<uint8_t>> files;
  files.push_back(std::move(color));
  return files;
}

Result<std::vector<offline::FolderFile>> CocoLayout::list_files(const Description& description,
                                                                const offline::FrameLines& lines) const {
  const Categories& categories = categories_.value();
  std::vector<std::string> images, annotations;
  for (const auto& [number, text] : lines) {
    const ordered_json line = ordered_json::parse(text);
    ordered_json image;
    image["id"] = number + 1;
    image["file_name"] = color_name(description, number);
    image["width"] = description.width;
    image["height"] = description.height;
    image["license"] = 1;
    image["camera"] = description.cameras[description.index_of_camera(number)];
    for (const char* name : {"cam_K", "cam_R_w2c", "cam_t_w2c"}) image[name] = line.at(name);
    images.push_back(image.dump());
    const Points points = find_points(line);
    for (const ordered_json& label : line.at("instances")) {
      const Instance* const instance = description.find_instance(label.at("instance").get<uint32_t>());
      const uint32_t category = instance ? categories.category_of(*instance) : 0;
      if (category == 0 || label.at("px_count_visib") == 0) continue;
      ordered_json annotation;
      annotation["id"] = annotations.size() + 1;
      annotation["image_id"] = number + 1;
      annotation["category_id"] = category;
      annotation["iscrowd"] = 0;
      annotation["bbox"] = label.at("bbox_visib");
      annotation["area"] = label.at("px_count_visib");
      annotation["segmentation"] = {{"size", {description.height, description.width}},
                                    {"counts", label.at("counts")}};
      add_keypoints(points, instance->number, categories.points_of(category), annotation);
      annotation["amodal_bbox"] = label.at("bbox_obj");
      annotation["amodal_area"] = label.at("px_count_all");
      annotation["visibility"] = label.at("visib_fract");
      for (const char* name : {"truncated", "instance", "obj_id", "cam_R_m2c", "cam_t_m2c"})
        annotation[name] = label.at(name);
      annotations.push_back(annotation.dump());
    }
  }
  const ordered_json info = {{"description", "written by fire3dv dataset"}, {"version", "1.0"}};
  const ordered_json license = {
      {"id", 1}, {"name", description.license.empty() ? "not stated" : description.license}, {"url", ""}};
  std::vector<offline::FolderFile> files;
  files.push_back(text_file(
      "annotations.json", "{\"info\":" + info.dump() + ",\n\"licenses\":[" + license.dump() +
                              "],\n\"categories\":" + categories_json(categories).dump() + ",\n\"images\":" +
                              json_list(images) + ",\n\"annotations\":" + json_list(annotations) + "}\n"));
  return files;
}

std::string CocoLayout::conventions(const Description&) const {
  return R"(COCO's layout.

| file | contents |
|---|---|
| `images/IMAGE.png` | 8-bit colours, sRGB; images of one moment follow one another, camera by camera |
| `annotations.json` | `images`, `categories`, `annotations` |

- `bbox`: left, top, width, height of the visible part; `area`: its pixels.
- `segmentation`: compressed run lengths (RLE) of the visible part, as pycocotools reads them.
- `keypoints`: x, y, v; v is 2 (visible), 1 (hidden by another surface), 0 (outside of the image, with
  0 for x and y). x and y count from the centre of the top left pixel.
- A category is a class (`semantic` in the extras of glTF nodes); nodes without a class are left out.
  In a scene without classes each object is a category.
- Beyond COCO, of annotations: `amodal_bbox` and `amodal_area` of the instance as if it were drawn alone,
  clipped at the image's border; `visibility`, `area` divided by `amodal_area`; `truncated`: a part is outside
  of the image; `instance`, `obj_id`, `cam_R_m2c`, `cam_t_m2c` (BOP's definitions, mm). Instances without
  a visible pixel have no annotation. Of images: `cam_K`, `cam_R_w2c`, `cam_t_w2c`.
)";
}

}  // namespace

std::unique_ptr<Layout> make_coco_layout() {
  return std::make_unique<CocoLayout>();
}

}  // namespace fire3dv::dataset
