#include "renderer/dataset/randomize/randomizer.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <set>

#include "base/log.h"
#include "base/nearest_names.h"
#include "base/text.h"
#include "base/words.h"
#include "renderer/dataset/randomize/axes.h"
#include "renderer/dataset/randomize/scene_additions.h"
#include "renderer/passes/view/view.h"
#include "renderer/scene/derived/variants.h"
#include "renderer/scene/model/node_names.h"
#include "renderer/scene/textures/environment.h"
#include "renderer/state/edits/node_transform.h"

namespace fire3dv::dataset {
namespace {

constexpr size_t kMaxMaps = 4;             // in memory
constexpr size_t kMaxParameters = 10'000;  // of an image

glm::dmat3 turn_of(const glm::dvec3& degrees) {
  const glm::dvec3 angle = glm::radians(degrees);
  const glm::dmat4 one(1);
  return glm::dmat3(glm::rotate(one, angle.z, {0, 0, 1}) * glm::rotate(one, angle.y, {0, 1, 0}) *
                    glm::rotate(one, angle.x, {1, 0, 0}));
}

// Direction from the target to the eye: azimuth from +Z towards +X, elevation above the horizon.
glm::dvec3 direction_of(double azimuth_deg, double elevation_deg) {
  const double azimuth = glm::radians(azimuth_deg), elevation = glm::radians(elevation_deg);
  return {std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
          std::cos(azimuth) * std::cos(elevation)};
}

std::vector<std::string> names_of(const std::vector<scene::Node>& nodes) {
  std::vector<std::string> names;
  for (const scene::Node& node : nodes) names.push_back(node.name);
  return names;
}
std::vector<std::string> paths_of(const std::vector<scene::Node>& nodes) {
  std::vector<std::string> paths;
  for (const scene::Node& node : nodes) paths.push_back(node.path);
  return paths;
}
// The first one, glTF's default material, has no name.
std::vector<std::string> material_names(const scene::Scene& scene) {
  std::vector<std::string> names;
  for (size_t i = 0; i < scene.materials.size(); ++i) names.push_back(material_name(scene, i));
  return names;
}

// Draws of settled poses, relative to the node's parent.
constexpr const char* kSettledPosition = "settled_m";
constexpr const char* kSettledRotation = "settled_rotation";
Field settled_field(FieldType type) {
  Field field;
  field.type = type;
  field.most = type == FieldType::rotation ? 1 : 1e9;
  field.least = -field.most;
  return field;
}

bool is_placed(const Entry& fields) {
  return fields.find("look_at") || fields.find("position_m");
}

bool fits(const DrawnValue& value, const Field& field) {
  const auto are_in = [&](size_t count) {
    return value.numbers.size() == count &&
           std::all_of(value.numbers.begin(), value.numbers.end(),
                       [&](double each) { return each >= field.least && each <= field.most; });
  };
  switch (field.type) {
    case FieldType::number:
      return are_in(1);
    case FieldType::chance:
      return are_in(1) && (value.numbers[0] == 0 || value.numbers[0] == 1);
    case FieldType::vector:
    case FieldType::place:
      return are_in(3);
    case FieldType::rotation: {
      if (!are_in(4)) return false;
      double square = 0;
      for (const double part : value.numbers) square += part * part;
      return std::abs(square - 1) < 1e-3;
    }
    case FieldType::word:
    case FieldType::files:
      return value.numbers.empty() &&
             std::find(field.words.begin(), field.words.end(), value.text) != field.words.end();
    case FieldType::file:
    case FieldType::flag:
      break;
  }
  return false;
}

}  // namespace

class Randomizer::Draws {
 public:
  Draws(const Randomizer& owner, std::string prefix, const Entry& fields, DrawnValues& record)
      : owner_(owner), prefix_(std::move(prefix)), fields_(fields), record_(record) {}

  std::optional<double> number(const char* name) {
    const Field* const field = fields_.find(name);
    if (!field) return {};
    if (const DrawnValue* const given = find_given(name)) return given->numbers[0];
    const double value = draw_of(name).number(field->number);
    return record(name, {{value}, {}}), value;
  }
  std::optional<bool> chance(const char* name) {
    const Field* const field = fields_.find(name);
    if (!field) return {};
    if (const DrawnValue* const given = find_given(name)) return given->numbers[0] != 0;
    const bool value = draw_of(name).unit() < field->number.low;
    return record(name, {{value ? 1.0 : 0.0}, {}}), value;
  }
  std::optional<glm::dvec3> vector(const char* name) {
    const Field* const field = fields_.find(name);
    if (!field) return {};
    if (const DrawnValue* const given = find_given(name))
      return glm::dvec3(given->numbers[0], given->numbers[1], given->numbers[2]);
    const glm::dvec3 value = draw_of(name).vector(field->vector);
    return record(name, {{value.x, value.y, value.z}, {}}), value;
  }
  std::optional<glm::dquat> rotation(const char* name) {
    if (!fields_.find(name)) return {};
    if (const DrawnValue* const given = find_given(name))
      return glm::normalize(
          glm::dquat(given->numbers[3], given->numbers[0], given->numbers[1], given->numbers[2]));
    const glm::dquat value = draw_of(name).rotation();
    return record(name, {{value.x, value.y, value.z, value.w}, {}}), value;
  }
  // A whole number.
  std::optional<double> count(const char* name) {
    const Field* const field = fields_.find(name);
    if (!field) return {};
    if (const DrawnValue* const given = find_given(name)) return given->numbers[0];
    const double value = std::round(draw_of(name).number(field->number));
    return record(name, {{value}, {}}), value;
  }
  // One of the object's own, whatever its fields: a choice among many objects, or a result of physics.
  bool choice(const char* name, bool value) {
    if (const DrawnValue* const given = find_given(name)) return given->numbers[0] != 0;
    return record(name, {{value ? 1.0 : 0.0}, {}}), value;
  }
  // Null: not given. It is not recorded.
  const DrawnValue* given(const char* name) const {
    const auto frame = owner_.given_.find(owner_.frame_);
    if (frame == owner_.given_.end()) return nullptr;
    const auto found = frame->second.find(prefix_ + name);
    return found == frame->second.end() ? nullptr : &found->second;
  }
  void note(const char* name, DrawnValue value) { record(name, std::move(value)); }
  double rank(const char* name) const { return draw_of(name).unit(); }
  std::optional<std::string> word(const char* name) {
    const Field* const field = fields_.find(name);
    if (!field) return {};
    if (const DrawnValue* const given = find_given(name)) return given->text;
    const std::string& value = field->words[draw_of(name).index(field->words.size())];
    return record(name, {{}, value}), value;
  }

 private:
  ParameterDraw draw_of(const char* name) const { return {owner_.plan_.seed, owner_.frame_, prefix_ + name}; }
  void record(const char* name, DrawnValue value) { record_.emplace_back(prefix_ + name, std::move(value)); }
  // Checked by check_given().
  const DrawnValue* find_given(const char* name) {
    const DrawnValue* const found = given(name);
    if (found) record(name, *found);
    return found;
  }

  const Randomizer& owner_;
  std::string prefix_;
  const Entry& fields_;
  DrawnValues& record_;
};

std::vector<Randomizer::Object> Randomizer::match(const Plan& plan, Section section,
                                                  const std::vector<std::string>& names,
                                                  const std::vector<std::string>& paths) {
  std::vector<Object> objects;
  std::set<std::string> titles;
  for (uint32_t i = 0; i < names.size(); ++i) {
    const std::string& path = i < paths.size() ? paths[i] : names[i];
    Object object;
    object.index = i;
    for (const Entry& entry : plan.of(section)) {
      if (!matches(entry.pattern, names[i]) && !matches(entry.pattern, path)) continue;
      for (const auto& [name, field] : entry.fields) object.fields.fields[name] = field;
    }
    if (object.fields.fields.empty()) continue;
    // Names may be equal, or end with the number of another.
    const std::string first =
        std::string(name_of(section)) + "." + printable_text(names[i].empty() ? path : names[i], 300);
    std::string title = first;
    for (uint32_t number = 2; !titles.insert(title).second; ++number)
      title = first + "#" + std::to_string(number);
    object.title = title + ".";
    objects.push_back(std::move(object));
  }
  return objects;
}

Randomizer::Randomizer(const Plan& plan, const std::vector<std::string>& cameras)
    : plan_(plan), cameras_(match(plan, Section::cameras, cameras, {})), camera_count_(cameras.size()) {
  for (const auto& [image, values] : plan.given.images) {
    for (const auto& [name, value] : values) given_[image / camera_count_][name] = value;
  }
}

std::vector<Randomizer::Unmatched> Randomizer::unmatched(const Plan& plan, const scene::Scene& scene,
                                                         const std::vector<std::string>& cameras) {
  std::vector<Unmatched> found;
  const auto check = [&](Section section, const char* what, auto&& has, auto&& known) {
    for (const Entry& entry : plan.of(section)) {
      if (has(entry.pattern)) continue;
      std::string word = entry.pattern;
      std::erase(word, '*');
      found.push_back({plan.file + ":" + std::to_string(entry.line) + ": " + name_of(section) + ": no " +
                           what + " has the name " + quote(entry.pattern) +
                           name_hint(word, known(word), name_of(section)),
                       entry.pattern.find('*') != std::string::npos});
    }
  };
  const auto any = [](const std::vector<std::string>& names, const std::string& pattern) {
    return std::any_of(names.begin(), names.end(), [&](const auto& name) { return matches(pattern, name); });
  };
  const std::vector<std::string> names = names_of(scene.nodes), paths = paths_of(scene.nodes);
  check(
      Section::cameras, "camera of the set", [&](const std::string& p) { return any(cameras, p); },
      [&](const std::string&) { return cameras; });
  check(
      Section::nodes, "node", [&](const std::string& p) { return any(names, p) || any(paths, p); },
      [&](const std::string& word) { return scene::node_names(scene, word); });
  check(
      Section::materials, "material", [&](const std::string& p) { return any(material_names(scene), p); },
      [&](const std::string&) { return material_names(scene); });
  std::vector<std::string> lights;
  for (const scene::Node& node : scene.nodes) {
    if (node.light != scene::kNone) lights.push_back(node.name.empty() ? node.path : node.name);
  }
  check(
      Section::lights, "node with a light",
      [&](const std::string& p) {
        return std::any_of(scene.nodes.begin(), scene.nodes.end(), [&](const scene::Node& node) {
          return node.light != scene::kNone && (matches(p, node.name) || matches(p, node.path));
        });
      },
      [&](const std::string&) { return lights; });
  return found;
}

Result<void> Randomizer::set_scene(const scene::Scene& scene, const settings::DrawSettings& settings) {
  scene_ = &scene;
  names_.emplace(scene);
  exposure_ = settings.post.exposure;
  nodes_ = match(plan_, Section::nodes, names_of(scene.nodes), paths_of(scene.nodes));
  materials_ = match(plan_, Section::materials, material_names(scene), {});
  lights_ = match(plan_, Section::lights, names_of(scene.nodes), paths_of(scene.nodes));
  std::erase_if(lights_,
                [&](const Object& object) { return scene.nodes[object.index].light == scene::kNone; });
  // Distractors have their own section.
  const std::set<uint32_t> nodes_of_distractors = distractor_nodes(plan_, scene);
  std::erase_if(nodes_, [&](const Object& object) { return nodes_of_distractors.contains(object.index); });
  distractors_.clear();
  if (const Entry* const entry = plan_.distractor_entry()) {
    for (const std::string& file : entry->find("files")->words) {
      for (uint32_t copy = 1; copy <= copies_of(*entry); ++copy) {
        const uint32_t node = find_distractor(scene, file, copy);
        if (node == scene::kNone) continue;
        distractors_.push_back(
            {node, "distractors." + printable_text(file, 300) + "#" + std::to_string(copy) + ".", *entry});
      }
    }
  }
  shapes_.emplace(scene);
  size_t parameters = 0;
  for (const auto* objects : {&cameras_, &nodes_, &materials_, &lights_, &distractors_}) {
    for (const Object& object : *objects) {
      parameters += object.fields.fields.size();
      const Field* const target = object.fields.find("look_at");
      if (target && !target->node.empty() && names_->find(target->node) == scene::kNone)
        return Error{plan_.file + ":" + std::to_string(target->line) + ": " + object.title +
                     "look_at: the scene has no single node " + quote(target->node) +
                     ": write its name or path, or [x, y, z]" +
                     (names_->has(target->node)
                          ? "; several have it"
                          : name_hint(target->node, scene::node_names(scene, target->node), "nodes"))};
    }
  }
  if (parameters > kMaxParameters)
    return Error{plan_.file + ": " + std::to_string(parameters) +
                 " parameters of an image are drawn, more than " + std::to_string(kMaxParameters) +
                 ": match fewer objects"};
  if (auto good = check_lights(); !good) return good;
  warn_of_no_effect();
  if (auto good = check_variants(); !good) return good;
  return check_given();
}

bool Randomizer::has_lens() const {
  return std::any_of(cameras_.begin(), cameras_.end(),
                     [](const Object& object) { return object.fields.find("f_number") != nullptr; });
}

void Randomizer::warn_once(const std::string& text) {
  if (warned_.insert(text).second) log_message(warning(text));
}

void Randomizer::warn_of_no_effect() {
  const auto list = [&](const std::vector<Object>& objects, const char* field, const char* why,
                        auto&& has_none) {
    std::vector<std::string> titles;
    for (const Object& object : objects) {
      if (object.fields.find(field) && has_none(object.index))
        titles.push_back(quote(object.title.substr(0, object.title.size() - 1)));
    }
    constexpr size_t kMaxListed = 5;
    const size_t count = titles.size();
    if (count == 0) return;
    titles.resize(std::min(count, kMaxListed));
    warn_once(std::string(field) + " has no effect where " + why + ": " + joined(titles) +
              (count > kMaxListed ? ", ..." : ""));
  };
  const auto& materials = scene_->materials;
  list(materials_, "alpha", "the material is opaque",
       [&](uint32_t i) { return scene::drawn_alpha_mode(materials[i]) == scene::AlphaMode::opaque; });
  list(materials_, "normal_scale", "the material has no normal map",
       [&](uint32_t i) { return materials[i].normal_texture.texture == scene::kNone; });
  for (const char* field : {"metallic", "roughness"})
    list(materials_, field, "the material is unlit", [&](uint32_t i) { return materials[i].unlit; });
  list(lights_, "radius_m", "the light is directional", [&](uint32_t i) {
    return scene_->lights[scene_->nodes[i].light].type == scene::LightType::directional;
  });
}

// Places are of the world; the pose of a light that is placed, too, would move those below it.
Result<void> Randomizer::check_lights() const {
  std::set<uint32_t> placed;
  for (const Object& object : lights_) {
    if (is_placed(object.fields)) placed.insert(object.index);
  }
  const auto line_of = [&](uint32_t light) {
    const auto object = std::ranges::find(lights_, light, &Object::index);
    const Field* const field = object->fields.find("look_at");
    return (field ? field : object->fields.find("position_m"))->line;
  };
  for (const uint32_t light : placed) {
    for (uint32_t above = scene_->nodes[light].parent; above != scene::kNone;
         above = scene_->nodes[above].parent) {
      if (placed.contains(above))
        return Error{plan_.file + ":" + std::to_string(line_of(light)) +
                     ": lights: " + quote(scene_->nodes[light].path) +
                     " lies below a light that is placed, too: place one of them"};
    }
  }
  return {};
}

Result<void> Randomizer::check_variants() const {
  for (const Entry& entry : plan_.of(Section::scene)) {
    const Field* const field = entry.find("variant");
    if (!field) continue;
    for (const std::string& word : field->words) {
      if (auto found = scene::find_variant(*scene_, word); !found)
        return Error{plan_.file + ":" + std::to_string(field->line) +
                     ": scene.variant: " + found.error().message};
    }
  }
  return {};
}

Result<void> Randomizer::check_given() const {
  std::map<std::string, const Field*, std::less<>> known;
  const auto add = [&](const std::string& title, const Entry& fields) {
    for (const auto& [name, field] : fields.fields) {
      const bool is_drawn = field.type != FieldType::file && field.type != FieldType::flag;
      if (is_drawn && field.node.empty()) known[title + name] = &field;
    }
  };
  static const Field position = settled_field(FieldType::vector),
                     rotation = settled_field(FieldType::rotation);
  static const Field visible = [] {
    Field field;
    field.type = FieldType::chance;
    field.most = 1;
    return field;
  }();
  for (const auto* objects : {&cameras_, &nodes_, &materials_, &lights_}) {
    for (const Object& object : *objects) add(object.title, object.fields);
  }
  for (const auto* objects : {&nodes_, &distractors_}) {
    for (const Object& object : *objects) {
      if (objects == &distractors_) {
        add(object.title, object.fields);
        known[object.title + "visible"] = &visible;
        known.erase(object.title + "files");
        known.erase(object.title + "copies");
        known.erase(object.title + "count");
      }
      if (!object.fields.has_flag("settle")) continue;
      known[object.title + kSettledPosition] = &position;
      known[object.title + kSettledRotation] = &rotation;
    }
  }
  if (const Entry* const entry = plan_.distractor_entry()) known["distractors.count"] = entry->find("count");
  for (const Section section : {Section::environment, Section::background, Section::scene}) {
    for (const Entry& entry : plan_.of(section)) add(std::string(name_of(section)) + ".", entry);
  }
  for (const auto& [image, values] : plan_.given.images) {
    for (const auto& [name, value] : values) {
      const auto found = known.find(name);
      const std::string at = plan_.given.file + ": image " + std::to_string(image) + ": " + quote(name);
      if (found == known.end())
        return Error{at + " is no parameter that " + plan_.file + " draws: add it there"};
      if (!fits(value, *found->second))
        return Error{at + " has a value that the field cannot have: see docs/randomization.md"};
      if (given_.at(image / camera_count_).at(name) != value)
        return Error{
            at + " differs from the value of another image of its frame: " + std::to_string(camera_count_) +
            " images in succession, one of each camera, are a frame"};
    }
  }
  return {};
}

Result<void> Randomizer::change_frame(uint64_t frame, state::UserEdits& edits,
                                      settings::DrawSettings& settings) {
  frame_ = frame;
  of_frame_.clear();
  settling_.clear();
  for (const Object& object : nodes_) change_node(object, edits);
  for (const Object& object : materials_) change_material(object, edits);
  for (const Object& object : lights_) change_light(object, edits);
  change_distractors(edits);
  hidden_ = edits.hidden;
  hidden_.insert(edits.removed.begin(), edits.removed.end());
  step_ = Step::settle;
  for (const Entry& entry : plan_.of(Section::scene)) {
    Draws draws(*this, "scene.", entry, of_frame_);
    if (const auto variant = draws.word("variant")) {
      if (const auto found = scene::find_variant(*scene_, *variant)) edits.variant = *found;
    }
  }
  return change_settings(settings);
}

void Randomizer::change_node(const Object& object, state::UserEdits& edits) {
  Draws draws(*this, object.title, object.fields, of_frame_);
  const auto visible = draws.chance("visible");
  if (visible && !*visible)
    edits.hidden.insert(object.index);
  else if (object.fields.has_flag("settle"))
    settling_.push_back(object);
  const auto edited = edits.transforms.find(object.index);
  const glm::dmat4 before(edited == edits.transforms.end() ? scene_->nodes[object.index].parent_from_node
                                                           : state::parent_from_node(edited->second));
  place_node(object, draws, before, edits);
}

// Of all files and copies as many as `count` are shown, those that come first in an order that is drawn.
void Randomizer::change_distractors(state::UserEdits& edits) {
  const Entry* const entry = plan_.distractor_entry();
  if (!entry) return;
  const double count = *Draws(*this, "distractors.", *entry, of_frame_).count("count");
  std::vector<std::pair<double, size_t>> order;
  for (size_t i = 0; i < distractors_.size(); ++i)
    order.emplace_back(Draws(*this, distractors_[i].title, *entry, of_frame_).rank("order"), i);
  std::sort(order.begin(), order.end());
  std::vector<bool> is_chosen(distractors_.size());
  for (size_t i = 0; i < order.size(); ++i) is_chosen[order[i].second] = static_cast<double>(i) < count;
  for (size_t i = 0; i < distractors_.size(); ++i) {
    const Object& object = distractors_[i];
    Draws draws(*this, object.title, object.fields, of_frame_);
    if (!draws.choice("visible", is_chosen[i])) {
      edits.hidden.insert(object.index);
      continue;
    }
    place_node(object, draws, glm::dmat4(1), edits);
    if (object.fields.has_flag("settle")) settling_.push_back(object);
  }
}

void Randomizer::place_node(const Object& object, Draws& draws, const glm::dmat4& before,
                            state::UserEdits& edits) {
  const auto position = draws.vector("position_m"), move = draws.vector("move_m"),
             turn = draws.vector("turn_deg");
  const auto rotation = draws.rotation("rotation");
  const auto scale = draws.number("scale");
  if (!position && !move && !turn && !rotation && !scale) return;
  glm::dvec3 origin = position.value_or(glm::dvec3(before[3]));
  if (move) origin += *move;
  glm::dmat3 axes(before);
  if (turn) axes = turn_of(*turn) * axes;
  if (rotation) axes = glm::mat3_cast(*rotation) * axes;
  if (scale) axes *= *scale;
  glm::dmat4 after(axes);
  after[3] = glm::dvec4(origin, 1);
  edits.transforms[object.index] = state::to_transform(glm::mat4(after));
}

void Randomizer::change_material(const Object& object, state::UserEdits& edits) {
  Draws draws(*this, object.title, object.fields, of_frame_);
  const auto edited = edits.materials.find(object.index);
  scene::MaterialFactors factors =
      edited == edits.materials.end() ? scene::factors_of(scene_->materials[object.index]) : edited->second;
  if (const auto color = draws.vector("base_color"))
    factors.base_color = glm::vec4(*color, factors.base_color.a);
  if (const auto alpha = draws.number("alpha")) factors.base_color.a = static_cast<float>(*alpha);
  if (const auto emissive = draws.vector("emissive")) factors.emissive = *emissive;
  const auto set = [&](const char* name, float& factor) {
    if (const auto value = draws.number(name)) factor = static_cast<float>(*value);
  };
  set("metallic", factors.metallic);
  set("roughness", factors.roughness);
  set("normal_scale", factors.normal_scale);
  edits.materials[object.index] = factors;
  scene::MaterialTextures textures;
  const auto choose = [&](const char* name, uint32_t& texture) {
    if (const auto file = draws.word(name))
      texture = find_texture(*scene_, *file, std::string_view(name) == "base_color_texture");
  };
  choose("base_color_texture", textures.base_color);
  choose("normal_texture", textures.normal);
  choose("roughness_texture", textures.metallic_roughness);
  if (textures != scene::MaterialTextures()) edits.textures[object.index] = textures;
}

void Randomizer::change_light(const Object& object, state::UserEdits& edits) {
  const auto has = [&](const char* field) { return object.fields.find(field) != nullptr; };
  if (!has("intensity") && !has("color") && !has("radius_m") && !has("on")) return;
  Draws draws(*this, object.title, object.fields, of_frame_);
  const auto edited = edits.lights.find(object.index);
  scene::Light light =
      edited == edits.lights.end() ? scene_->lights[scene_->nodes[object.index].light] : edited->second;
  if (const auto intensity = draws.number("intensity")) light.intensity = static_cast<float>(*intensity);
  if (const auto color = draws.vector("color")) light.color = *color;
  if (const auto radius = draws.number("radius_m")) light.radius_m = static_cast<float>(*radius);
  if (const auto on = draws.chance("on"); on && !*on) light.intensity = 0;
  edits.lights[object.index] = light;
}

// The same object while it is cached, so that the renderer stays.
Result<std::shared_ptr<const scene::EnvironmentImage>> Randomizer::load_map(const std::string& name) {
  if (const auto found = maps_.find(name); found != maps_.end()) return found->second;
  auto image = scene::load_environment(plan_.maps.at(name).path);
  if (!image) return Error{plan_.file + ": environment.map: " + image.error().message};
  if (maps_.size() >= kMaxMaps) maps_.clear();
  auto map = std::make_shared<const scene::EnvironmentImage>(std::move(*image));
  maps_[name] = map;
  return std::shared_ptr<const scene::EnvironmentImage>(map);
}

Result<void> Randomizer::change_settings(settings::DrawSettings& settings) {
  for (const Entry& entry : plan_.of(Section::environment)) {
    Draws draws(*this, "environment.", entry, of_frame_);
    if (const auto name = draws.word("map")) {
      auto map = load_map(*name);
      if (!map) return map.error();
      settings.environment = std::move(*map);
    }
    if (const auto value = draws.number("intensity"))
      settings.environment_intensity = static_cast<float>(*value);
    if (const auto value = draws.number("rotation_deg"))
      settings.environment_rotation_rad = static_cast<float>(glm::radians(*value));
  }
  for (const Entry& entry : plan_.of(Section::background)) {
    Draws draws(*this, "background.", entry, of_frame_);
    if (const auto color = draws.vector("color")) {
      settings.background = settings::Background();
      settings.background.color = *color;
    }
  }
  return {};
}

// The object's pose in the world after path, position_m, look_at and the shell.
Randomizer::Placement Randomizer::place(Draws& draws, const Entry& fields, const state::PoseState& poses,
                                        const glm::dmat4& world_from_object) const {
  Placement result{world_from_object, {}};
  if (const Field* const path = fields.find("path")) {
    const auto trajectory = plan_.paths.find(path->words[0]);
    const auto share = draws.number("path_at");
    if (trajectory != plan_.paths.end() && share) result.world_from_object = trajectory->second.at(*share);
  }
  glm::dvec3 eye(result.world_from_object[3]);
  if (const auto position = draws.vector("position_m")) eye = *position;
  if (const Field* const field = fields.find("look_at")) {
    glm::dvec3 target(0);
    if (field->node.empty())
      target = *draws.vector("look_at");
    else
      target = glm::dvec3(poses.world_from_node(names_->find(field->node))[3]);
    target += draws.vector("look_at_offset_m").value_or(glm::dvec3(0));
    if (const auto distance = draws.number("distance_m")) {
      const double azimuth = *draws.number("azimuth_deg"), elevation = *draws.number("elevation_deg");
      eye = target + *distance * direction_of(azimuth, elevation);
    }
    // Of an eye in the target any direction is right.
    if (glm::distance(eye, target) > 0)
      result.world_from_object = glm::dmat4(passes::look_at_pose(glm::vec3(eye - target), glm::vec3(0)));
    result.target = target;
  }
  result.world_from_object[3] = glm::dvec4(eye, 1);
  return result;
}

Result<bool> Randomizer::add_transforms(const state::PoseState& poses, state::NodeTransforms& transforms) {
  if (step_ == Step::settle) {
    step_ = Step::lights;
    warn_of_driven_nodes(poses);
    const auto settled = settle_nodes(poses, transforms);
    if (!settled || *settled) return settled;
  }
  if (step_ == Step::lights) {
    step_ = Step::done;
    if (place_lights(poses, transforms)) return true;
  }
  return false;
}

// Nodes without triangles stay, as do those that fall out of the scene.
Result<bool> Randomizer::settle_nodes(const state::PoseState& poses, state::NodeTransforms& transforms) {
  if (settling_.empty()) return false;
  std::set<uint32_t> settling;
  for (const Object& object : settling_) settling.insert(object.index);
  shapes_->begin_frame(settling, hidden_);
  const auto parent_from_world = [&](uint32_t node) {
    const uint32_t parent = scene_->nodes[node].parent;
    return parent == scene::kNone ? glm::dmat4(1) : glm::inverse(glm::dmat4(poses.world_from_node(parent)));
  };
  const auto place = [&](const Object& object, const glm::dvec3& position, const glm::dquat& rotation) {
    const glm::dmat4 before =
        parent_from_world(object.index) * glm::dmat4(poses.world_from_node(object.index));
    glm::dmat4 after = glm::mat4_cast(rotation) * glm::scale(glm::dmat4(1), axes_of(before).scale);
    after[3] = glm::dvec4(position, 1);
    transforms[object.index] = state::to_transform(glm::mat4(after));
  };
  std::vector<const Object*> falling;
  std::vector<FallingBody> bodies;
  bool has_any = false;
  for (const Object& object : settling_) {
    if (!shapes_->falls(object.index)) continue;
    Draws draws(*this, object.title, object.fields, of_frame_);
    const DrawnValue* const position = draws.given(kSettledPosition);
    const DrawnValue* const rotation = draws.given(kSettledRotation);
    if (position && rotation) {
      draws.note(kSettledPosition, *position);
      draws.note(kSettledRotation, *rotation);
      const auto &p = position->numbers, &r = rotation->numbers;
      place(object, {p[0], p[1], p[2]}, glm::normalize(glm::dquat(r[3], r[0], r[1], r[2])));
      has_any = true;
      continue;
    }
    FallingBody body = shapes_->falling_body(poses, object.index);
    if (body.hulls.empty()) {
      warn_once(object.title + "settle: the node has no triangles, and stays");
      continue;
    }
    falling.push_back(&object);
    bodies.push_back(std::move(body));
  }
  if (bodies.empty()) return has_any;
  const auto resting = settle(shapes_->fixed_triangles(poses), bodies);
  if (!resting) return Error{plan_.file + ": " + resting.error().message};
  for (size_t i = 0; i < falling.size(); ++i) {
    const RestingBody& rest = (*resting)[i];
    if (rest.has_fallen)
      warn_once(falling[i]->title + "settle: the node falls out of the scene, and stays where it began");
    else if (!rest.is_at_rest)
      warn_once(falling[i]->title + "settle: the node still moves after " + std::to_string(kMaxSettleSteps) +
                " steps, and is drawn where it is then");
    glm::dmat4 world = glm::mat4_cast(rest.rotation);
    world[3] = glm::dvec4(rest.position_m, 1);
    const glm::dmat4 parent_from_body = parent_from_world(falling[i]->index) * world;
    const glm::dvec3 position(parent_from_body[3]);
    const glm::dquat rotation = axes_of(parent_from_body).rotation;
    Draws draws(*this, falling[i]->title, falling[i]->fields, of_frame_);
    draws.note(kSettledPosition, {{position.x, position.y, position.z}, {}});
    draws.note(kSettledRotation, {{rotation.x, rotation.y, rotation.z, rotation.w}, {}});
    place(*falling[i], position, rotation);
  }
  return true;
}

bool Randomizer::place_lights(const state::PoseState& poses, state::NodeTransforms& transforms) {
  bool has_any = false;
  for (const Object& object : lights_) {
    if (!is_placed(object.fields)) continue;
    Draws draws(*this, object.title, object.fields, of_frame_);
    const uint32_t parent = scene_->nodes[object.index].parent;
    const glm::dmat4 world_from_light =
        place(draws, object.fields, poses, glm::dmat4(poses.world_from_node(object.index))).world_from_object;
    const glm::dmat4 parent_from_world =
        parent == scene::kNone ? glm::dmat4(1) : glm::inverse(glm::dmat4(poses.world_from_node(parent)));
    transforms[object.index] = state::to_transform(glm::mat4(parent_from_world * world_from_light));
    has_any = true;
  }
  return has_any;
}

void Randomizer::warn_of_driven_nodes(const state::PoseState& poses) {
  for (const auto* objects : {&nodes_, &lights_}) {
    for (const Object& object : *objects) {
      const Entry& fields = object.fields;
      const bool is_placed = fields.find("position_m") || fields.find("move_m") || fields.find("turn_deg") ||
                             fields.find("rotation") || fields.find("scale") || fields.find("look_at") ||
                             fields.has_flag("settle");
      if (!is_placed || !poses.age_of_driver(object.index)) continue;
      warn_once(object.title + "*: its place has no effect: a recorded stream moves the node");
    }
  }
}

void Randomizer::change_camera(uint64_t image, const state::PoseState& poses,
                               app::CameraRig::Placed& camera) {
  of_image_.clear();
  noise_ = 0;
  const auto found = std::find_if(cameras_.begin(), cameras_.end(), [&](const Object& object) {
    return object.index == image % camera_count_;
  });
  if (found == cameras_.end()) return;
  Draws draws(*this, found->title, found->fields, of_image_);
  const Placement placed = place(draws, found->fields, poses, glm::dmat4(camera.world_from_camera));
  glm::dmat4 pose = placed.world_from_object;
  if (const auto move = draws.vector("move_m")) pose[3] += pose * glm::dvec4(*move, 0);
  glm::dmat3 axes(pose);
  if (const auto roll = draws.number("roll_deg")) axes = axes * turn_of({0, 0, *roll});
  if (const auto turn = draws.vector("turn_deg")) axes = axes * turn_of(*turn);
  for (int i = 0; i < 3; ++i) pose[i] = glm::dvec4(axes[i], 0);
  camera.world_from_camera = glm::mat4(pose);
  if (const auto fov = draws.number("fov_deg"))
    camera.camera.vertical_fov_rad = static_cast<float>(glm::radians(*fov));
  if (const auto stops = draws.number("exposure_ev")) {
    const float before = camera.camera.exposure > 0 ? camera.camera.exposure : exposure_;
    camera.camera.exposure = before * static_cast<float>(std::exp2(*stops));
  }
  if (const auto aperture = draws.number("f_number")) {
    double focus_m = scene::kMinFocusDistanceM;
    if (const auto distance = draws.number("focus_distance_m"))
      focus_m = *distance;
    else if (placed.target)
      focus_m = std::max(focus_m, -glm::dot(*placed.target - glm::dvec3(pose[3]), glm::normalize(axes[2])));
    camera.camera.lens = {static_cast<float>(*aperture), static_cast<float>(focus_m), true};
  }
  noise_ = draws.number("noise").value_or(0);
}

DrawnValues Randomizer::drawn() const {
  DrawnValues all = of_frame_;
  all.insert(all.end(), of_image_.begin(), of_image_.end());
  return all;
}

}  // namespace fire3dv::dataset
