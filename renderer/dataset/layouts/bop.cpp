#include <nlohmann/json.hpp>
#include <utility>

#include "renderer/dataset/layouts/image_files.h"
#include "renderer/dataset/layouts/layouts.h"

namespace fire3dv::dataset {
namespace {

using nlohmann::ordered_json;

std::string scene_folder(uint32_t camera) {
  return "train/" + six_digits(camera);
}

// One line for each key, as BOP's tools write it.
class Entries {
 public:
  void add(uint64_t key, const std::string& value) {
    text_ += (text_.empty() ? "{\n  \"" : ",\n  \"") + std::to_string(key) + "\": " + value;
  }
  std::string text() const { return (text_.empty() ? "{" : text_) + "\n}\n"; }

 private:
  std::string text_;
};

offline::FolderFile models_info(const Description& description) {
  Entries infos;
  for (const Object& object : description.objects) {
    ordered_json info;
    info["diameter"] = object.diameter_mm;
    constexpr const char* kAxes[] = {"x", "y", "z"};
    for (size_t i = 0; i < 3; ++i) info[std::string("min_") + kAxes[i]] = object.min_mm[i];
    for (size_t i = 0; i < 3; ++i) info[std::string("size_") + kAxes[i]] = object.size_mm[i];
    infos.add(object.id, info.dump());
  }
  return text_file("models/models_info.json", infos.text());
}

// Parameters of the first camera; those of each image are in scene_camera.json.
offline::FolderFile first_camera(const Description& description, const ordered_json& first) {
  const ordered_json& k = first.at("cam_K");
  ordered_json camera;
  camera["cx"] = k.at(2);
  camera["cy"] = k.at(5);
  camera["depth_scale"] = description.depth_unit_mm;
  camera["fx"] = k.at(0);
  camera["fy"] = k.at(4);
  camera["height"] = description.height;
  camera["width"] = description.width;
  return text_file("camera.json", camera.dump(2) + "\n");
}

class BopLayout final : public Layout {
 public:
  std::optional<Depth16> depth16(const Description& description) const override {
    return Depth16{description.depth_unit_mm, "0 there; a larger --depth-scale reaches farther"};
  }
  std::vector<std::string> folders(const Description& description) const override;
  std::vector<std::string> static_names(const Description& description) const override;
  std::string color_name(const Description& description, uint64_t image) const override;
  std::vector<std::string> file_names(const Description& description, uint64_t image,
                                      size_t instances) const override;
  Result<std::vector<std::vector<uint8_t>>> encode(const Description& description,
                                                   const sinks::FrameImage& image, const ImageLabels& labels,
                                                   std::vector<uint8_t> color) const override;
  Result<std::vector<offline::FolderFile>> list_files(const Description& description,
                                                      const offline::FrameLines& lines) const override;
  std::string conventions(const Description& description) const override;
};

std::vector<std::string> BopLayout::folders(const Description& description) const {
  std::vector<std::string> folders{"models"};
  for (uint32_t camera = 0; camera < description.cameras.size(); ++camera) {
    for (const char* kind : {"rgb", "depth", "mask", "mask_visib"})
      folders.push_back(scene_folder(camera) + "/" + kind);
  }
  return folders;
}

std::vector<std::string> BopLayout::static_names(const Description& description) const {
  std::vector<std::string> names;
  for (const Object& object : description.objects)
    names.push_back("models/obj_" + six_digits(object.id) + ".ply");
  return names;
}

std::string BopLayout::color_name(const Description& description, uint64_t image) const {
  return scene_folder(description.index_of_camera(image)) + "/rgb/" +
         six_digits(description.frame_of(image)) + ".png";
}

std::vector<std::string> BopLayout::file_names(const Description& description, uint64_t image,
                                               size_t instances) const {
  const std::string folder = scene_folder(description.index_of_camera(image)) + "/";
  const std::string number = six_digits(description.frame_of(image));
  std::vector<std::string> names{color_name(description, image), folder + "depth/" + number + ".png"};
  for (const char* kind : {"mask/", "mask_visib/"}) {
    for (size_t i = 0; i < instances; ++i)
      names.push_back(folder + kind + number + "_" + six_digits(i) + ".png");
  }
  return names;
}

Result<std::vector<std::vector<uint8_t>>> BopLayout::encode(const Description&,
                                                            const sinks::FrameImage& image,
                                                            const ImageLabels& labels,
                                                            std::vector<uint8_t> color) const {
  std::vector<std::vector<uint8_t>> files;
  files.push_back(std::move(color));
  files.push_back(encode_gray_png(labels.depth_units, image.width, image.height));
  const auto add_mask = [&](const Runs& pixels) {
    files.push_back(
        encode_gray_png(mask_pixels(pixels, image.width, image.height), image.width, image.height));
  };
  for (const InstanceLabel& instance : labels.instances) add_mask(instance.silhouette.value().pixels);
  for (const InstanceLabel& instance : labels.instances) add_mask(instance.visible);
  return files;
}

Result<std::vector<offline::FolderFile>> BopLayout::list_files(const Description& description,
                                                               const offline::FrameLines& lines) const {
  std::vector<offline::FolderFile> files{models_info(description)};
  const size_t cameras = description.cameras.size();
  std::vector<Entries> of_camera(cameras), of_poses(cameras), of_infos(cameras);
  for (const auto& [image, text] : lines) {
    const ordered_json line = ordered_json::parse(text);
    if (image == 0) files.push_back(first_camera(description, line));
    const uint32_t scene = description.index_of_camera(image);
    const uint64_t number = description.frame_of(image);
    ordered_json camera, poses = ordered_json::array(), infos = ordered_json::array();
    camera["cam_K"] = line.at("cam_K");
    camera["cam_R_w2c"] = line.at("cam_R_w2c");
    camera["cam_t_w2c"] = line.at("cam_t_w2c");
    camera["depth_scale"] = description.depth_unit_mm;
    for (const ordered_json& instance : line.at("instances")) {
      ordered_json pose, info;
      for (const char* name : {"cam_R_m2c", "cam_t_m2c", "obj_id"}) pose[name] = instance.at(name);
      for (const char* name :
           {"bbox_obj", "bbox_visib", "px_count_all", "px_count_valid", "px_count_visib", "visib_fract"})
        info[name] = instance.at(name);
      poses.push_back(std::move(pose));
      infos.push_back(std::move(info));
    }
    of_camera[scene].add(number, camera.dump());
    of_poses[scene].add(number, poses.dump());
    of_infos[scene].add(number, infos.dump());
  }
  for (uint32_t scene = 0; scene < cameras; ++scene) {
    const std::string at = scene_folder(scene);
    files.push_back(text_file(at + "/scene_camera.json", of_camera[scene].text()));
    files.push_back(text_file(at + "/scene_gt.json", of_poses[scene].text()));
    files.push_back(text_file(at + "/scene_gt_info.json", of_infos[scene].text()));
  }
  return files;
}

std::string BopLayout::conventions(const Description& description) const {
  return R"(BOP's layout, one scene for each camera.

| file | contents |
|---|---|
| `camera.json` | intrinsics of the first image |
| `models/obj_NNNNNN.ply`, `models/models_info.json` | models in millimetres; diameter, box |
| `train/SCENE/rgb/IMAGE.png` | 8-bit colours, sRGB |
| `train/SCENE/depth/IMAGE.png` | 16 bits; times `depth_scale` = millimetres along the camera's axis; 0: no surface, or too far |
| `train/SCENE/mask/IMAGE_GT.png` | silhouette of instance GT as if it were drawn alone, 255 |
| `train/SCENE/mask_visib/IMAGE_GT.png` | its visible part, 255 |
| `train/SCENE/scene_camera.json` | `cam_K` (by rows, pixels), `cam_R_w2c`, `cam_t_w2c` (mm), `depth_scale` |
| `train/SCENE/scene_gt.json` | for each instance `obj_id`, `cam_R_m2c` (by rows), `cam_t_m2c` (mm) |
| `train/SCENE/scene_gt_info.json` | `bbox_obj`, `bbox_visib` (left, top, width, height in pixels), pixel counts, `visib_fract` |

GT is the position in the lists of `scene_gt.json`. Instances of which no pixel is within the image are
left out; those that others hide are listed, with `visib_fract` 0 and -1 in `bbox_visib`.
Silhouettes, `bbox_obj` and `px_count_all` end at the image's border, so that `visib_fract` is the
visible share of what is within the image (BOP's own tools count pixels outside, too). `frames.jsonl`
says which instances are `truncated`. `px_count_valid` counts pixels of the silhouette with a depth.
`depth_scale` is )" +
         ordered_json(description.depth_unit_mm).dump() + ".\n";
}

}  // namespace

std::unique_ptr<Layout> make_bop_layout() {
  return std::make_unique<BopLayout>();
}

}  // namespace fire3dv::dataset
