#include "convert/mjcf/deformable/mjcf_flexes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include "convert/mjcf/deformable/mjcf_skins.h"
#include "convert/mjcf/deformable/skin_data.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

constexpr size_t kMaxFlexNumbers = 60'000'000, kMaxFlexes = 10'000, kMaxBones = 65'535;
constexpr double kMaxFlexCoordinate = 1 << 30;

class FlexReader {
 public:
  FlexReader(const MjcfCopy& copy, const MjcfTree& tree, const MjcfPosedBodies& posed, MjcfScene& scene)
      : copy_(copy), source_(*copy.source), tree_(tree), posed_(posed), scene_(scene) {}

  Result<void> read(const MjcfElement& element) {
    const MjcfAttributes from = source_.attributes(element, MjcfDefaults::kMain);
    if (from.find("node")) return Error{"vertices that follow the nodes of a lattice are not supported"};
    MjcfSkin skin = flex_appearance(source_, from, scene_);
    if (!skin.name.empty()) skin.name = name_in_copy(skin.name);
    FlexShape shape;
    shape.dimension = from.integer("dim", 2);
    if (Result<void> done = read_flex_shape(from, "vertex", shape); !done) return done;
    std::vector<Influences> influences;
    if (Result<void> done = read_bodies(from.text("body"), shape, influences, skin); !done) return done;
    for (const uint32_t point : shape.elements)
      if (point >= shape.points.size())
        return Error{"an element names vertex " + std::to_string(point) + " of " +
                     std::to_string(shape.points.size()) + ", counted from 0"};
    set_flex_surface(shape, influences, from.number("radius", 0.005), from.flag("flatskin", false), skin);
    bind_to_pose(posed_, 0, skin);
    scene_.skins.push_back(std::move(skin));
    return {};
  }

 private:
  std::string name_in_copy(const std::string& own) const { return copy_.prefix + own + copy_.suffix; }

  // One body for all vertices, or one for each. Vertices are in the frames of their bodies.
  Result<void> read_bodies(const std::string& names, FlexShape& shape, std::vector<Influences>& influences,
                           MjcfSkin& skin) const {
    std::istringstream words(names);
    std::map<size_t, uint16_t> bones;
    for (std::string name; words >> name;) {
      const auto body = tree_.body_index.find(name == "world" ? name : name_in_copy(name));
      if (body == tree_.body_index.end()) return Error{"there is no body " + quote(name)};
      if (bones.size() == kMaxBones)
        return Error{"it has more than " + std::to_string(kMaxBones) + " bodies"};
      const auto [bone, is_new] = bones.try_emplace(body->second, static_cast<uint16_t>(skin.bones.size()));
      if (is_new) skin.bones.push_back({body->second, {}});
      influences.emplace_back();
      influences.back().joints[0] = bone->second;
      influences.back().weights[0] = 1;
    }
    if (influences.empty()) return Error{"it has no body"};
    if (shape.points.empty()) shape.points.resize(influences.size(), glm::dvec3(0));
    if (influences.size() == 1) influences.resize(shape.points.size(), influences[0]);
    if (influences.size() != shape.points.size())
      return Error{"it has " + std::to_string(influences.size()) + " bodies for " +
                   std::to_string(shape.points.size()) + " vertices"};
    return {};
  }

  const MjcfCopy& copy_;
  MjcfSource& source_;
  const MjcfTree& tree_;
  const MjcfPosedBodies& posed_;
  MjcfScene& scene_;
};

bool is_rigid(const MjcfSkin& skin) {
  return std::all_of(skin.surface.influences.begin(), skin.surface.influences.end(),
                     [](const Influences& each) { return each.weights[0] == 1; });
}

}  // namespace

MjcfSkin flex_appearance(MjcfSource& source, const MjcfAttributes& from, MjcfScene& scene) {
  MjcfSkin skin;
  skin.name = from.name();
  skin.group = from.integer("group", 0);
  if (const auto rgba = from.vec4("rgba"))
    for (int i = 0; i < 4; ++i) skin.rgba[static_cast<size_t>(i)] = static_cast<float>((*rgba)[i]);
  if (const std::string material = from.text("material"); !material.empty())
    skin.material = source.material(material, from.element(), scene);
  return skin;
}

Result<std::vector<double>> flex_numbers(const MjcfAttributes& from, const char* attribute) {
  const std::string* const text = from.find(attribute);
  if (!text) return std::vector<double>();
  if (!is_mjcf_numbers(*text, kMaxFlexNumbers))
    return Error{std::string(attribute) + " holds something else than numbers"};
  return mjcf_numbers(*text, kMaxFlexNumbers);
}

Result<void> read_flex_shape(const MjcfAttributes& from, const char* points, FlexShape& shape) {
  if (shape.dimension < 1 || shape.dimension > 3) return Error{"dim is not from 1 to 3"};
  const auto coordinates = flex_numbers(from, points), elements = flex_numbers(from, "element"),
             uvs = flex_numbers(from, "texcoord"), uv_elements = flex_numbers(from, "elemtexcoord");
  for (const auto* numbers : {&coordinates, &elements, &uvs, &uv_elements})
    if (!*numbers) return numbers->error();
  const auto corners = static_cast<size_t>(shape.dimension) + 1;
  if (coordinates->size() % 3 != 0)
    return Error{std::string(points) + " is not three numbers for each vertex"};
  if (elements->empty() || elements->size() % corners != 0)
    return Error{"element is not " + std::to_string(corners) + " numbers for each element"};
  for (size_t i = 0; i + 3 <= coordinates->size(); i += 3) {
    const glm::dvec3 point((*coordinates)[i], (*coordinates)[i + 1], (*coordinates)[i + 2]);
    if (!(std::abs(point.x) <= kMaxFlexCoordinate && std::abs(point.y) <= kMaxFlexCoordinate &&
          std::abs(point.z) <= kMaxFlexCoordinate))
      return Error{"a vertex is not finite, or beyond 2^30"};
    shape.points.push_back(point);
  }
  const auto add_index = [](double number, std::vector<uint32_t>& to) {
    const bool is_valid = number >= 0 && number < 4e9;
    if (is_valid) to.push_back(static_cast<uint32_t>(number));
    return is_valid;
  };
  for (const double number : *elements)
    if (!add_index(number, shape.elements)) return Error{"an element names a negative or huge vertex"};
  for (size_t i = 0; i + 2 <= uvs->size(); i += 2) shape.uvs.emplace_back((*uvs)[i], (*uvs)[i + 1]);
  if (shape.uvs.empty()) return {};
  for (const double number : *uv_elements)
    if (!add_index(number, shape.uv_elements)) return Error{"elemtexcoord holds a negative or huge number"};
  if (shape.uv_elements.empty()) shape.uv_elements = shape.elements;
  const bool is_valid = shape.uv_elements.size() == shape.elements.size() &&
                        std::all_of(shape.uv_elements.begin(), shape.uv_elements.end(),
                                    [&](uint32_t i) { return i < shape.uvs.size(); });
  if (!is_valid) return Error{"it has no texture coordinate for a corner of its elements"};
  return {};
}

void set_flex_surface(const FlexShape& shape, const std::vector<Influences>& influences, double radius,
                      bool is_flat, MjcfSkin& skin) {
  FlexSurface made = flex_surface(shape, std::clamp(radius, 1e-6, 1e6), is_flat);
  skin.surface = std::move(made.surface);
  for (const uint32_t point : made.points) skin.surface.influences.push_back(influences[point]);
  inflate(0, skin.surface);
}

void add_flexes(const MjcfTree& tree, const MjcfPosedBodies& posed, MjcfScene& scene) {
  for (const MjcfTreeSkin& made : tree.skins) {
    scene.skins.push_back(made.skin);
    if (is_rigid(made.skin)) bind_to_pose(posed, made.inflation, scene.skins.back());
  }
  std::set<std::pair<const MjcfElement*, std::string>> known;
  for (size_t i = 0; i < tree.copies.size(); ++i) {
    const MjcfCopy& copy = tree.copies[i];
    for (const MjcfElement& section : copy.source->root().children) {
      if (section.kind != "deformable") continue;
      for (const MjcfElement& element : section.children) {
        if (element.kind != "flex" || scene.skins.size() >= kMaxFlexes) continue;
        if (!known.emplace(&element, copy.prefix + '\n' + copy.suffix).second) continue;
        const Result<void> done = FlexReader(copy, tree, posed, scene).read(element);
        // Bodies of replicas have other names than those that a flex knows.
        if (!done && i == 0)
          copy.source->messages().warn(element.where() + " is left out: " + done.error().message);
      }
    }
  }
}

}  // namespace fire3dv::convert
