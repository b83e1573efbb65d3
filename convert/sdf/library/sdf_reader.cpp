#include "convert/sdf/library/sdf_reader.h"

#include <algorithm>
#include <exception>
#include <map>
#include <new>
#include <optional>
#include <sdf/Actor.hh>
#include <sdf/Element.hh>
#include <sdf/Gui.hh>
#include <sdf/Link.hh>
#include <sdf/Model.hh>
#include <sdf/ParserConfig.hh>
#include <sdf/Root.hh>
#include <sdf/Sensor.hh>
#include <sdf/Visual.hh>
#include <sdf/World.hh>
#include <utility>

#include "base/plural.h"
#include "base/text.h"
#include "convert/sdf/library/sdf_appearance.h"
#include "convert/sdf/library/sdf_joints.h"
#include "convert/sdf/library/sdf_messages.h"
#include "convert/sdf/library/sdf_trial.h"
#include "convert/sdf/library/sdf_values.h"

namespace fire3dv::convert {
namespace {

constexpr size_t kMaxItems = 200'000;

// Pose of the camera of Gazebo Classic's window, or of that of newer ones, which a plugin has.
std::optional<ignition::math::Pose3d> gui_view(const sdf::Gui* gui) {
  const sdf::ElementPtr element = gui ? gui->Element() : nullptr;
  if (!element) return std::nullopt;
  if (const sdf::ElementPtr camera = element->FindElement("camera"))
    if (const sdf::ElementPtr pose = camera->FindElement("pose")) return pose->Get<ignition::math::Pose3d>();
  for (sdf::ElementPtr plugin = element->FindElement("plugin"); plugin;
       plugin = plugin->GetNextElement("plugin")) {
    const sdf::ElementPtr pose = plugin->FindElement("camera_pose");
    if (!pose) continue;
    const auto [parsed, is_set] = pose->Get<ignition::math::Pose3d>("", {});
    if (is_set) return parsed;
  }
  return std::nullopt;
}

class Reader {
 public:
  Reader(const SdfDocuments& documents, SdfScene& scene, std::vector<std::string>& warnings)
      : documents_(documents), scene_(scene), warnings_(warnings) {}

  void add(const sdf::World& world) {
    scene_.name = world.Name();
    for (uint64_t i = 0; i < world.ModelCount(); ++i) add(*world.ModelByIndex(i), std::nullopt, "");
    for (uint64_t i = 0; i < world.LightCount(); ++i) add(*world.LightByIndex(i), std::nullopt);
    for (uint64_t i = 0; i < world.ActorCount(); ++i) warn_of(*world.ActorByIndex(i));
    std::optional<ignition::math::Pose3d> view = gui_view(world.Gui());
    const bool has_cameras = std::any_of(scene_.items.begin(), scene_.items.end(),
                                         [](const SdfItem& item) { return item.camera.has_value(); });
    if (!view && has_cameras) view = ignition::math::Pose3d(6, 0, 6, 0, 0.5, 3.14);  // Gazebo's default
    if (!view || !is_sound(*view)) return;
    scene_.view.emplace();
    scene_.view->translation = vec3(view->Pos());
    scene_.view->rotation = quat(view->Rot());
    scene_.view->near_m = 0.01;
    scene_.view->far_m = 1000;
  }

  void add(const sdf::Root& root) {
    if (const sdf::Model* model = root.Model()) add(*model, std::nullopt, "");
    if (const sdf::Light* light = root.Light()) add(*light, std::nullopt);
    if (const sdf::Actor* actor = root.Actor()) warn_of(*actor);
  }

  // Reports what concerns many entities.
  void finish() {
    if (without_shadow_ > 0)
      warnings_.push_back(counted(without_shadow_, "visual") +
                          " without <cast_shadows> cast shadows all the same");
    if (items_left_out_)
      warnings_.push_back("entities beyond " + std::to_string(kMaxItems) + " are left out: split the file");
  }

 private:
  // Returns nothing when there are too many entities.
  template <typename Entity>
  std::optional<size_t> add_item(SdfEntity kind, const Entity& from, std::optional<size_t> parent) {
    if (scene_.items.size() >= kMaxItems) {
      items_left_out_ = true;
      return std::nullopt;
    }
    SdfItem item;
    item.kind = kind;
    item.name = from.Name();
    item.parent = parent;
    ignition::math::Pose3d pose;
    // The pose graph misses where the file has errors, which libsdformat reports.
    if (!from.SemanticPose().Resolve(pose).empty()) pose = from.RawPose();
    scene_.items.push_back(std::move(item));
    const size_t index = scene_.items.size() - 1;
    if (is_sound(pose)) {
      scene_.items[index].translation = vec3(pose.Pos());
      scene_.items[index].rotation = glm::normalize(quat(pose.Rot()));
    } else {
      warnings_.push_back(where(index) + ": its <pose> is not finite, or beyond 1e9 m; it is not moved");
    }
    return index;
  }

  std::string where(size_t index) const {
    std::vector<size_t> scope{index};
    while (scene_.items[scope.back()].parent) scope.push_back(*scene_.items[scope.back()].parent);
    std::string name;
    for (size_t i = scope.size(); i-- > 0;)
      name = scoped_sdf_name(name, scene_.items[scope[i]].name, scene_.items[scope[i]].kind);
    return std::string(name_of(scene_.items[index].kind)) + " " + quote(name);
  }

  void add(
      const sdf::Model& model, std::optional<size_t> parent,
      const std::string& scope) {  // NOLINT(misc-no-recursion): xml_root() and SdfDocuments limit the depth
    const std::optional<size_t> item = add_item(SdfEntity::model, model, parent);
    if (!item) return;
    const std::string prefix = scope + model.Name() + "::";
    for (uint64_t i = 0; i < model.LinkCount(); ++i) add(*model.LinkByIndex(i), *item, prefix);
    for (uint64_t i = 0; i < model.ModelCount(); ++i) add(*model.ModelByIndex(i), item, prefix);
    add_sdf_joints(model, *item, prefix, links_, where(*item), scene_, warnings_);
  }

  void add(const sdf::Link& link, size_t model, const std::string& prefix) {
    const std::optional<size_t> item = add_item(SdfEntity::link, link, model);
    if (!item) return;
    links_.emplace(prefix + link.Name(), *item);
    for (uint64_t i = 0; i < link.VisualCount(); ++i) add(*link.VisualByIndex(i), *item);
    for (uint64_t i = 0; i < link.LightCount(); ++i) add(*link.LightByIndex(i), *item);
    for (uint64_t i = 0; i < link.SensorCount(); ++i) add(*link.SensorByIndex(i), *item);
    if (link.ParticleEmitterCount() > 0) warnings_.push_back(where(*item) + ": particles are not drawn");
  }

  void add(const sdf::Visual& visual, size_t link) {
    const std::optional<size_t> item = add_item(SdfEntity::visual, visual, link);
    if (!item) return;
    const std::string location = where(*item);
    if (!visual.CastShadows()) ++without_shadow_;
    SdfItem& made = scene_.items[*item];
    made.transparency = visual.Transparency();
    if (visual.Geom()) made.shape = sdf_shape(*visual.Geom(), documents_, location, warnings_);
    if (visual.Material()) made.material = sdf_material(*visual.Material(), documents_, location, warnings_);
  }

  void add(const sdf::Light& light, std::optional<size_t> parent) {
    if (const std::optional<size_t> item = add_item(SdfEntity::light, light, parent))
      scene_.items[*item].light = sdf_light(light);
  }

  void add(const sdf::Sensor& sensor, size_t link) {
    if (!sensor.CameraSensor()) return;
    if (const std::optional<size_t> item = add_item(SdfEntity::sensor, sensor, link))
      scene_.items[*item].camera = sdf_camera(*sensor.CameraSensor(), where(*item), warnings_);
  }

  void warn_of(const sdf::Actor& actor) {
    warnings_.push_back("actor " + quote(actor.Name()) + " is left out: animated skins of SDF are not drawn");
  }

  const SdfDocuments& documents_;
  SdfScene& scene_;
  std::vector<std::string>& warnings_;
  std::map<std::string, size_t> links_;
  uint64_t without_shadow_ = 0;
  bool items_left_out_ = false;
};

sdf::ParserConfig config() {
  sdf::ParserConfig made;
  made.SetUnrecognizedElementsPolicy(sdf::EnforcementPolicy::WARN);
  made.SetFindCallback([](const std::string&) { return std::string(); });
  return made;
}

Result<SdfScene> read(const std::string& copy, const SdfDocuments& documents,
                      std::vector<std::string>& warnings) {
  const std::string path = documents.original(copy).string(), file = quote(path);
  SdfMessages messages(documents);
  SdfScene scene;
  try {
    sdf::ParserConfig::GlobalConfig() = config();  // that of included files
    sdf::Root root;
    for (const sdf::Error& error : root.Load(copy, config())) messages.add(error);
    std::vector<std::string> said = messages.take();
    for (std::string& each : said)  // the first word is a path, or there is none
      if (!each.starts_with('/') && !each.starts_with(path)) each = path + ": " + each;
    if (root.WorldCount() == 0 && !root.Model() && !root.Light() && !root.Actor()) {
      std::string reasons;
      said.insert(said.begin(), warnings.begin(), warnings.end());  // includes that were left out
      constexpr size_t kMaxReasons = 5;
      for (size_t i = 0; i < said.size() && i < kMaxReasons; ++i) reasons += (i > 0 ? "; " : "") + said[i];
      return Error{file + " has no world and no model that can be read" +
                   (reasons.empty() ? std::string(": add a <world> or a <model>") : ": " + reasons)};
    }
    warnings.insert(warnings.end(), said.begin(), said.end());
    std::vector<std::string> notes;
    Reader reader(documents, scene, notes);
    if (root.WorldCount() > 0) {
      reader.add(*root.WorldByIndex(0));
      if (root.WorldCount() > 1)
        notes.push_back("the file has " + std::to_string(root.WorldCount()) + " worlds; only " +
                        quote(root.WorldByIndex(0)->Name()) + ", the first, is drawn");
    } else {
      reader.add(root);
    }
    reader.finish();
    for (const std::string& note : notes) warnings.push_back(path + ": " + note);
    for (const std::string& message : messages.take()) warnings.push_back(path + ": " + message);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& fault) {
    return Error{file + " cannot be read by libsdformat: " + printable_text(fault.what(), 300)};
  }
  return scene;
}

}  // namespace

Result<SdfScene> read_sdf_scene(const std::string& copy, const SdfDocuments& documents,
                                std::vector<std::string>& warnings) {
  const Result<void> survived = try_in_process([&] {
    std::vector<std::string> ignored;
    (void)read(copy, documents, ignored);
  });
  if (!survived)
    return Error{quote(documents.original(copy).string()) + " cannot be read by libsdformat: " +
                 survived.error().message + "; look for damaged elements with \"gz sdf -k\""};
  return read(copy, documents, warnings);
}

}  // namespace fire3dv::convert
