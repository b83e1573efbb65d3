#include "renderer/editing/overlay_file.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "base/files.h"
#include "protocol/robot/robot_json.h"
#include "renderer/scene/model/shortest.h"

namespace fire3dv::state {
namespace {

using scene::shortest;

using Json = nlohmann::json;
using Ordered = nlohmann::ordered_json;
using robot::Fault;

constexpr const char* kRoot = "fire3dv_overlay";
constexpr const char* kLightTypes[] = {"directional", "point", "spot"};
constexpr size_t kMaxNameBytes = 64 << 10;
constexpr float kMaxConeRad = 1.5707964f + 1e-4f;  // as in glTF files

// --- text ---

template <typename Vector>
Ordered list(const Vector& vector, int length) {
  Ordered array = Ordered::array();
  for (int i = 0; i < length; ++i) array.push_back(shortest(vector[i]));
  return array;
}

void add_transform(Ordered& entry, const NodeTransform& transform) {
  if (transform.has_shear) {
    Ordered& columns = entry["matrix"] = Ordered::array();
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 4; ++row) columns.push_back(shortest(transform.matrix[column][row]));
    }
    return;
  }
  const glm::quat& q = transform.rotation;
  entry["translation"] = list(transform.translation, 3);
  entry["rotation"] = list(glm::vec4(q.x, q.y, q.z, q.w), 4);
  entry["scale"] = list(transform.scale, 3);
}

Ordered light_text(const scene::Light& light) {
  const scene::Light usual;
  Ordered text;
  text["type"] = kLightTypes[static_cast<size_t>(light.type)];
  text["color"] = list(light.color, 3);
  text["intensity"] = shortest(light.intensity);
  const auto add = [&](const char* name, float value, float otherwise) {
    if (value != otherwise) text[name] = shortest(value);
  };
  add("range", light.range_m, usual.range_m);
  add("radius", light.radius_m, usual.radius_m);
  add("angular_radius", light.angular_radius_rad, usual.angular_radius_rad);
  add("inner_cone", light.inner_cone_rad, usual.inner_cone_rad);
  add("outer_cone", light.outer_cone_rad, usual.outer_cone_rad);
  add("spread", light.spread, usual.spread);
  if (!light.casts_shadow) text["casts_shadow"] = false;
  return text;
}

void add_factors(Ordered& entry, const scene::MaterialFactors& factors) {
  entry["base_color"] = list(factors.base_color, 4);
  entry["emissive"] = list(factors.emissive, 3);
  entry["metallic"] = shortest(factors.metallic);
  entry["roughness"] = shortest(factors.roughness);
  entry["normal_scale"] = shortest(factors.normal_scale);
  entry["occlusion_strength"] = shortest(factors.occlusion_strength);
  entry["alpha_cutoff"] = shortest(factors.alpha_cutoff);
}

Ordered camera_text(const scene::Camera& camera) {
  const scene::Camera usual;
  Ordered text;
  if (camera.orthographic) {
    text["half_extent"] = list(camera.half_extent_m, 2);
  } else {
    text["vertical_fov"] = shortest(camera.vertical_fov_rad);
  }
  const auto add = [&](const char* name, float value, float otherwise) {
    if (value != otherwise) text[name] = shortest(value);
  };
  add("aspect", camera.aspect, usual.aspect);
  text["near"] = shortest(camera.near_m);
  add("far", camera.far_m, usual.far_m);
  add("f_number", camera.lens.f_number, usual.lens.f_number);
  add("focus_distance", camera.lens.focus_distance_m, usual.lens.focus_distance_m);
  add("pixel_aspect", camera.pixel_aspect, usual.pixel_aspect);
  if (camera.principal_point != usual.principal_point)
    text["principal_point"] = list(camera.principal_point, 2);
  return text;
}

void add_addition(Ordered& entry, const Addition& addition) {
  if (!addition.parent.empty()) entry["parent"] = addition.parent;
  if (const auto* light = std::get_if<scene::Light>(&addition.content)) entry["light"] = light_text(*light);
  if (const auto* camera = std::get_if<scene::Camera>(&addition.content))
    entry["camera"] = camera_text(*camera);
  if (const auto* copied = std::get_if<CopiedNode>(&addition.content)) entry["copy"] = copied->path;
  if (const auto* asset = std::get_if<AddedAsset>(&addition.content)) entry["asset"] = asset->uri;
  add_transform(entry, addition.transform);
}

void add_value(Ordered& entry, EditedProperty property, const EditedValue& value) {
  if (const auto* flag = std::get_if<bool>(&value))
    entry[property == EditedProperty::removed ? "removed" : "visible"] = *flag;
  if (const auto* transform = std::get_if<NodeTransform>(&value)) add_transform(entry, *transform);
  if (const auto* light = std::get_if<scene::Light>(&value)) entry["light"] = light_text(*light);
  if (const auto* factors = std::get_if<scene::MaterialFactors>(&value)) add_factors(entry, *factors);
  if (const auto* position = std::get_if<JointPosition>(&value)) entry["position"] = *position;
  if (const auto* variant = std::get_if<VariantName>(&value)) entry["variant"] = *variant;
  if (const auto* addition = std::get_if<Addition>(&value)) add_addition(entry, *addition);
}

// --- members of a file ---

constexpr float kTiny = 1e-12f;  // least value of what is more than 0

float number(const Json& value, const std::string& location, float least, float most) {
  const auto number = static_cast<float>(robot::number_of(value, location));
  if (number >= least && number <= most) return number;
  char text[64];  // two numbers of 14 characters at most
  if (least > 0 && least <= kTiny && !(number > most))
    std::snprintf(text, sizeof text, "must be more than 0");
  else
    std::snprintf(text, sizeof text, "is not between %g and %g", double{least}, double{most});
  throw Fault(location + " " + text);
}

template <int length>
glm::vec<length, float> numbers(const Json& value, const std::string& location, float least, float most) {
  if (!value.is_array() || value.size() != length)
    throw Fault(location + " is no list of " + std::to_string(length) + " numbers");
  glm::vec<length, float> vector;
  for (int i = 0; i < length; ++i)
    vector[i] = number(value[static_cast<size_t>(i)], location + "[" + std::to_string(i) + "]", least, most);
  return vector;
}

constexpr float kAny = 1e12f;

// Reads the members of an object one by one, and refuses those that nobody has read.
class Members {
 public:
  Members(const Json& object, std::string location) : object_(object), location_(std::move(location)) {
    if (!object.is_object()) throw Fault(location_ + " is no object");
  }
  std::string location(const char* name) const { return location_ + "." + name; }
  const Json* find(const char* name) {
    const Json* const value = robot::member(object_, name);
    if (value) ++read_;
    return value;
  }
  const Json& need(const char* name) {
    const Json* const value = find(name);
    if (!value) throw Fault(location_ + " has no member \"" + name + "\"");
    return *value;
  }
  void number_into(const char* name, float& value, float least, float most) {
    if (const Json* const found = find(name)) value = number(*found, location(name), least, most);
  }
  // names: all members that an object of this kind may have.
  void refuse_others(std::initializer_list<const char*> names) const {
    if (read_ == object_.size()) return;
    for (const auto& member : object_.items()) {
      bool known = false;
      for (const char* const name : names) known |= member.key() == name;
      if (!known) throw Fault(location_ + " has an unknown member " + robot::in_quotes(member.key()));
    }
    throw Fault(location_ + " has members that do not belong together");
  }

 private:
  const Json& object_;
  const std::string location_;
  size_t read_ = 0;
};

bool truth(const Json& value, const std::string& location) {
  if (!value.is_boolean()) throw Fault(location + " is neither true nor false");
  return value.get<bool>();
}

std::optional<NodeTransform> read_transform(Members& entry, const std::string& location) {
  NodeTransform transform;
  if (const Json* const matrix = entry.find("matrix")) {
    const auto n = numbers<4>;
    if (!matrix->is_array() || matrix->size() != 16)
      throw Fault(entry.location("matrix") + " is no list of 16 numbers");
    for (int column = 0; column < 4; ++column) {
      Json part = Json::array();
      for (int row = 0; row < 4; ++row) part.push_back((*matrix)[static_cast<size_t>(4 * column + row)]);
      transform.matrix[column] = n(part, entry.location("matrix"), -kAny, kAny);
    }
    transform.has_shear = true;
  } else if (const Json* const translation = entry.find("translation")) {
    transform.translation = numbers<3>(*translation, entry.location("translation"), -kAny, kAny);
    const glm::vec4 q = numbers<4>(entry.need("rotation"), entry.location("rotation"), -1.001f, 1.001f);
    transform.rotation = glm::quat(q.w, q.x, q.y, q.z);
    transform.scale = numbers<3>(entry.need("scale"), entry.location("scale"), -kAny, kAny);
  } else {
    return std::nullopt;
  }
  if (!is_valid(transform))
    throw Fault(location +
                " has an invalid transform: rotations are unit quaternions, and no axis has size 0");
  return transform;
}

scene::Light read_light(const Json& object, const std::string& location) {
  Members members(object, location);
  scene::Light light;
  const Json& type = members.need("type");
  size_t kind = 0;
  while (kind < std::size(kLightTypes) && type != kLightTypes[kind]) ++kind;
  if (kind == std::size(kLightTypes)) throw Fault(location + ".type is not directional, point or spot");
  light.type = static_cast<scene::LightType>(kind);
  light.color = numbers<3>(members.need("color"), location + ".color", 0, kAny);
  light.intensity = number(members.need("intensity"), location + ".intensity", 0, kAny);
  members.number_into("range", light.range_m, 0, kAny);
  members.number_into("radius", light.radius_m, 0, kAny);
  members.number_into("angular_radius", light.angular_radius_rad, 0, kMaxConeRad);
  members.number_into("inner_cone", light.inner_cone_rad, 0, kMaxConeRad);
  members.number_into("outer_cone", light.outer_cone_rad, 0, kMaxConeRad);
  members.number_into("spread", light.spread, 0, scene::kMaxLightSpread);
  if (light.type == scene::LightType::spot && light.inner_cone_rad >= light.outer_cone_rad)
    throw Fault(location + ".inner_cone is not less than outer_cone");
  if (const Json* const shadow = members.find("casts_shadow"))
    light.casts_shadow = truth(*shadow, location + ".casts_shadow");
  members.refuse_others({"type", "color", "intensity", "range", "radius", "angular_radius", "inner_cone",
                         "outer_cone", "spread", "casts_shadow"});
  return light;
}

scene::MaterialFactors read_factors(Members& entry) {
  scene::MaterialFactors factors;
  const auto one = [&](const char* name, float least, float most) {
    return number(entry.need(name), entry.location(name), least, most);
  };
  factors.base_color = numbers<4>(entry.need("base_color"), entry.location("base_color"), 0, 1);
  factors.emissive = numbers<3>(entry.need("emissive"), entry.location("emissive"), 0, kAny);
  factors.metallic = one("metallic", 0, 1);
  factors.roughness = one("roughness", 0, 1);
  factors.normal_scale = one("normal_scale", -kAny, kAny);
  factors.occlusion_strength = one("occlusion_strength", 0, 1);
  factors.alpha_cutoff = one("alpha_cutoff", 0, kAny);
  return factors;
}

JointPosition read_position(const Json& value, const std::string& location) {
  constexpr size_t kMaxNumbers = 7;  // of a free joint
  if (!value.is_array() || value.empty() || value.size() > kMaxNumbers)
    throw Fault(location + " is no list of 1 to 7 numbers");
  JointPosition position;
  for (const Json& number : value) position.push_back(robot::number_of(number, location));
  return position;
}

scene::Camera read_camera(const Json& object, const std::string& location) {
  Members members(object, location);
  scene::Camera camera;
  if (const Json* const extent = members.find("half_extent")) {
    camera.orthographic = true;
    camera.half_extent_m = numbers<2>(*extent, location + ".half_extent", kTiny, kAny);
  } else {
    camera.vertical_fov_rad =
        number(members.need("vertical_fov"), location + ".vertical_fov", 1e-6f, 3.1415f);
  }
  members.number_into("aspect", camera.aspect, 0, kAny);
  camera.near_m = number(members.need("near"), location + ".near", camera.orthographic ? 0 : kTiny, kAny);
  members.number_into("far", camera.far_m, 0, kAny);
  const bool is_infinite = camera.far_m == 0 && !camera.orthographic;
  if (!is_infinite && camera.far_m <= camera.near_m) throw Fault(location + ".far is not more than near");
  members.number_into("f_number", camera.lens.f_number, scene::kMinFNumber, scene::kMaxFNumber);
  members.number_into("focus_distance", camera.lens.focus_distance_m, scene::kMinFocusDistanceM,
                      scene::kMaxFocusDistanceM);
  if ((camera.lens.f_number == 0) != (camera.lens.focus_distance_m == 0))
    throw Fault(location + " has only one of f_number and focus_distance");
  members.number_into("pixel_aspect", camera.pixel_aspect, scene::kMinPixelAspect, scene::kMaxPixelAspect);
  if (const Json* const point = members.find("principal_point"))
    camera.principal_point = numbers<2>(*point, location + ".principal_point", -scene::kMaxPrincipalPoint,
                                        scene::kMaxPrincipalPoint);
  members.refuse_others({"half_extent", "vertical_fov", "aspect", "near", "far", "f_number", "focus_distance",
                         "pixel_aspect", "principal_point"});
  return camera;
}

std::string read_name(const Json& value, const std::string& location, bool may_be_empty) {
  if (!value.is_string() || value.get_ref<const std::string&>().size() > kMaxNameBytes)
    throw Fault(location + " is no text of at most 65536 bytes");
  if (!may_be_empty && value.get_ref<const std::string&>().empty()) throw Fault(location + " is empty");
  return value.get<std::string>();
}

Addition read_addition(Members& entry, const std::string& location) {
  Addition addition;
  if (const Json* const parent = entry.find("parent"))
    addition.parent = read_name(*parent, entry.location("parent"), true);
  size_t contents = 0;
  if (const Json* const light = entry.find("light"); light && ++contents)
    addition.content = read_light(*light, entry.location("light"));
  if (const Json* const camera = entry.find("camera"); camera && ++contents)
    addition.content = read_camera(*camera, entry.location("camera"));
  if (const Json* const copied = entry.find("copy"); copied && ++contents)
    addition.content = CopiedNode{read_name(*copied, entry.location("copy"), false)};
  if (const Json* const asset = entry.find("asset"); asset && ++contents)
    addition.content = AddedAsset{read_name(*asset, entry.location("asset"), false)};
  if (contents != 1) throw Fault(location + " does not have one of light, camera, copy and asset");
  if (const std::optional<NodeTransform> transform = read_transform(entry, location))
    addition.transform = *transform;
  return addition;
}

// The object that an entry names.
EditKey read_target(Members& entry, const std::string& location) {
  constexpr std::pair<const char*, EditedObject> kObjects[] = {{"node", EditedObject::node},
                                                               {"material", EditedObject::material},
                                                               {"joint", EditedObject::joint},
                                                               {"add", EditedObject::addition}};
  for (const auto& [member, object] : kObjects) {
    const Json* const name = entry.find(member);
    if (!name) continue;
    EditKey key{object, read_name(*name, entry.location(member), true), 0, {}};
    const auto count = [&](const char* of) -> std::optional<uint32_t> {
      const Json* const value = entry.find(of);
      if (!value) return std::nullopt;
      if (!value->is_number_unsigned() || value->get<uint64_t>() >= UINT32_MAX)
        throw Fault(entry.location(of) + " is no whole number from 0 on");
      return value->get<uint32_t>();
    };
    key.occurrence = count("occurrence").value_or(0);
    if (object == EditedObject::node) key.instance = count("instance");
    if (const Json* const of = object == EditedObject::material ? entry.find("of") : nullptr)
      key.owner = read_name(*of, entry.location("of"), false);
    return key;
  }
  throw Fault(location + " names no node, material, joint, addition or variant");
}

void read_entry(const Json& object, const std::string& location, EditDocument& document) {
  Members entry(object, location);
  const Json* const variant = entry.find("variant");
  EditKey key = variant ? variant_key() : read_target(entry, location);
  const size_t before = document.size();
  const auto add = [&](EditedProperty property, EditedValue value) {
    key.property = property;
    if (!document.emplace(key, std::move(value)).second)
      throw Fault(location + " edits " + describe(key) + " a second time");
  };
  if (variant) {
    add(EditedProperty::variant, read_name(*variant, entry.location("variant"), true));
    return entry.refuse_others({"variant"});
  }
  if (key.object == EditedObject::material) {
    add(EditedProperty::factors, read_factors(entry));
    return entry.refuse_others({"material", "of", "occurrence", "base_color", "emissive", "metallic",
                                "roughness", "normal_scale", "occlusion_strength", "alpha_cutoff"});
  }
  if (key.object == EditedObject::joint) {
    add(EditedProperty::position, read_position(entry.need("position"), entry.location("position")));
    return entry.refuse_others({"joint", "occurrence", "position"});
  }
  if (key.object == EditedObject::addition) {
    if (key.name.empty() || key.occurrence != 0) throw Fault(location + ".add is no name of one node");
    add(EditedProperty::added, read_addition(entry, location));
    return entry.refuse_others(
        {"add", "parent", "light", "camera", "copy", "asset", "translation", "rotation", "scale", "matrix"});
  }
  if (const Json* const visible = entry.find("visible"))
    add(EditedProperty::visible, truth(*visible, entry.location("visible")));
  if (const Json* const removed = entry.find("removed"))
    add(EditedProperty::removed, truth(*removed, entry.location("removed")));
  if (const std::optional<NodeTransform> transform = read_transform(entry, location))
    add(EditedProperty::transform, *transform);
  if (const Json* const light = entry.find("light"))
    add(EditedProperty::light, read_light(*light, entry.location("light")));
  entry.refuse_others({"node", "occurrence", "instance", "visible", "translation", "rotation", "scale",
                       "matrix", "light", "removed"});
  if (document.size() == before) throw Fault(location + " changes nothing");
}

EditDocument read_document(std::span<const std::byte> text) {
  const Json root = robot::parse_json(text, kRoot);
  const Json* const overlay = robot::member(root, kRoot);
  if (!overlay) throw Fault(std::string("it is no overlay file: it has no member \"") + kRoot + "\"");
  Members members(*overlay, kRoot);
  const Json& version = members.need("version");
  if (!version.is_number_integer() || version.get<int64_t>() < 1)
    throw Fault("version is no whole number from 1 on");
  if (version.get<int64_t>() > kOverlayVersion)
    throw Fault("it has version " + version.dump() + " of the format, and this program reads version " +
                std::to_string(kOverlayVersion) + "; use a newer program");
  (void)members.find("scene");
  const Json& edits = members.need("edits");
  members.refuse_others({"version", "scene", "edits"});
  if (!edits.is_array()) throw Fault("edits is no list");
  EditDocument document;
  size_t additions = 0;
  for (size_t i = 0; i < edits.size(); ++i) {
    read_entry(edits[i], "edits[" + std::to_string(i) + "]", document);
    if (robot::member(edits[i], "add") && ++additions > kMaxOverlayAdditions)
      throw Fault("it has more than " + std::to_string(kMaxOverlayAdditions) + " additions");
    if (document.size() > kMaxOverlayEdits)
      throw Fault("it has more than " + std::to_string(kMaxOverlayEdits) + " edits");
  }
  return document;
}

}  // namespace

std::string overlay_text(const EditDocument& document, const std::string& scene) {
  constexpr const char* kMembers[] = {"node", "material", "joint", "", "add"};  // by EditedObject
  constexpr auto kReplace = Ordered::error_handler_t::replace;  // names of a file may be invalid UTF-8
  const bool is_for_older = std::ranges::all_of(document, [](const auto& edit) {
    const EditKey& key = edit.first;
    return key.object != EditedObject::addition && key.owner.empty() && !key.instance;
  });
  const int version = is_for_older ? 1 : kOverlayVersion;
  std::string text = std::string("{\"") + kRoot + "\": {\n  \"version\": " + std::to_string(version) +
                     ",\n  \"scene\": " + Ordered(scene).dump(-1, ' ', false, kReplace) + ",\n  \"edits\": [";
  const char* separator = "\n    ";
  for (auto edit = document.begin(); edit != document.end();) {
    const EditKey& key = edit->first;
    Ordered entry;
    if (key.object != EditedObject::scene) entry[kMembers[static_cast<size_t>(key.object)]] = key.name;
    if (!key.owner.empty()) entry["of"] = key.owner;
    if (key.occurrence != 0) entry["occurrence"] = key.occurrence;
    if (key.instance) entry["instance"] = *key.instance;
    for (; edit != document.end() && edit->first.has_object_of(key); ++edit)
      add_value(entry, edit->first.property, edit->second);
    text += separator + entry.dump(-1, ' ', false, kReplace);
    separator = ",\n    ";
  }
  return text + "\n  ]\n}}\n";
}

Result<EditDocument> parse_overlay(std::span<const std::byte> text) {
  try {
    return read_document(text);
  } catch (const Fault& fault) {
    return Error{fault.what()};
  }
}

Result<EditDocument> load_overlay(const std::filesystem::path& file) {
  const Result<FileBytes> bytes = read_file(file, kMaxOverlayBytes);
  if (!bytes) return bytes.error();
  Result<EditDocument> document = parse_overlay(bytes->view());
  if (!document) return Error{file.string() + ": " + document.error().message};
  return document;
}

Result<void> save_overlay(const std::filesystem::path& file, const EditDocument& document,
                          const std::string& scene) {
  const std::string text = overlay_text(document, scene);
  if (document.size() > kMaxOverlayEdits || text.size() > kMaxOverlayBytes)
    return Error{file.string() + ": " + std::to_string(document.size()) +
                 " edits are more than an overlay file can hold; save the scene as .glb"};
  if (const Result<EditDocument> again = parse_overlay(std::as_bytes(std::span(text))); !again)
    return Error{file.string() + ": the edits could not be read again: " + again.error().message};
  return write_whole_file(file, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

}  // namespace fire3dv::state
