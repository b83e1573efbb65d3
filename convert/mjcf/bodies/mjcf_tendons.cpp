#include "convert/mjcf/bodies/mjcf_tendons.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "convert/mjcf/bodies/tendon_wrap.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

constexpr double kDefaultWidth_m = 0.003;

class TendonReader {
 public:
  TendonReader(const MjcfCopy& copy, const MjcfTree& tree, const MjcfPosedBodies& posed, MjcfScene& scene)
      : copy_(copy), source_(*copy.source), tree_(tree), posed_(posed), scene_(scene) {}

  // Whether all sites of a spatial tendon are in this copy.
  bool holds(const MjcfElement& element) const {
    return std::all_of(element.children.begin(), element.children.end(), [&](const MjcfElement& part) {
      return part.kind != "site" || tree_.site_index.contains(name_in_copy(part.text("site")));
    });
  }

  void read(const MjcfElement& element) {
    const size_t class_index = source_.class_of(element, MjcfDefaults::kMain);
    const MjcfAttributes from = source_.attributes(element, class_index, "tendon");
    MjcfTendon tendon;
    tendon.name = from.name().empty() ? from.name() : name_in_copy(from.name());
    if (element.kind == "spatial") {
      if (const auto rgba = from.vec4("rgba"))
        for (int i = 0; i < 4; ++i) tendon.rgba[static_cast<size_t>(i)] = static_cast<float>((*rgba)[i]);
      if (const std::string material = from.text("material"); !material.empty())
        tendon.material = source_.material(material, element, scene_);
      const double width = from.number("width", kDefaultWidth_m);
      const auto& color =
          mjcf_color(tendon.rgba, tendon.material ? &scene_.materials[*tendon.material].rgba : nullptr);
      if (is_shown_group(from.integer("group", 0)) && color[3] > 0 && width > 0) {
        tendon.max_points = count_points(element);
        if (tendon.max_points > 0) add_path(element, width, tendon);
      }
    }
    scene_.tendons.push_back(std::move(tendon));
  }

 private:
  std::string name_in_copy(const std::string& own) const { return copy_.prefix + own + copy_.suffix; }

  static size_t count_points(const MjcfElement& element) {
    size_t points = 0;
    for (const MjcfElement& part : element.children)
      points += part.kind == "site" ? 1 : part.kind == "geom" ? 2 : 0;
    return points < 2 ? 0 : points;
  }

  std::optional<glm::dvec3> site(const MjcfElement& user, const std::string& name) const {
    const auto found = tree_.site_index.find(name_in_copy(name));
    if (found == tree_.site_index.end()) {
      source_.messages().warn(user.where() + ": there is no site " + quote(name));
      return std::nullopt;
    }
    const MjcfSite& at = tree_.sites[found->second];
    return posed_.bodies[at.body] * at.pose.position;
  }

  // Goes from site to site, around the geom between them.
  void add_path(const MjcfElement& element, double width, MjcfTendon& tendon) const {
    std::optional<glm::dvec3> last;
    const MjcfElement* around = nullptr;
    for (const MjcfElement& part : element.children) {
      if (part.kind == "pulley") {
        last.reset();
        around = nullptr;
      } else if (part.kind == "geom") {
        around = &part;
      } else if (part.kind == "site") {
        const std::optional<glm::dvec3> next = site(part, part.text("site"));
        if (last && next) add_section(*last, *next, around, width, tendon);
        if (next) last = next;
        around = nullptr;
      }
    }
  }

  void add_section(const glm::dvec3& from, const glm::dvec3& to, const MjcfElement* around, double width,
                   MjcfTendon& tendon) const {
    const auto contact = around ? contact_with(*around, from, to) : std::nullopt;
    if (!contact) {
      tendon.pieces.push_back({from, to, width});
      return;
    }
    tendon.pieces.push_back({from, contact->first, width});
    tendon.pieces.push_back({contact->first, contact->second, width / 2});  // on the surface
    tendon.pieces.push_back({contact->second, to, width});
  }

  std::optional<std::pair<glm::dvec3, glm::dvec3>> contact_with(const MjcfElement& around,
                                                                const glm::dvec3& from,
                                                                const glm::dvec3& to) const {
    const auto found = tree_.geom_index.find(name_in_copy(around.text("geom")));
    if (found == tree_.geom_index.end()) {
      source_.messages().warn(around.where() + ": there is no geom " + quote(around.text("geom")));
      return std::nullopt;
    }
    const MjcfGeom& geom = tree_.geoms[found->second].geom;
    if (geom.shape != MjcfShape::sphere && geom.shape != MjcfShape::cylinder) {
      source_.messages().warn(around.where() + ": a tendon wraps around spheres and cylinders only");
      return std::nullopt;
    }
    std::optional<glm::dvec3> side;
    if (const std::string name = around.text("sidesite"); !name.empty()) side = site(around, name);
    return wrap_tendon(from, to, posed_.bodies[geom.body] * geom.pose, geom.size.x,
                       geom.shape == MjcfShape::sphere, side);
  }

  const MjcfCopy& copy_;
  MjcfSource& source_;
  const MjcfTree& tree_;
  const MjcfPosedBodies& posed_;
  MjcfScene& scene_;
};

constexpr size_t kMaxTendons = 100'000, kMaxChecks = 10'000'000;

std::vector<const MjcfElement*> tendons_of(const MjcfSource& source) {
  std::vector<const MjcfElement*> tendons;
  for (const MjcfElement& section : source.root().children) {
    if (section.kind != "tendon") continue;
    for (const MjcfElement& tendon : section.children) tendons.push_back(&tendon);
  }
  return tendons;
}

}  // namespace

void add_tendons(const MjcfTree& tree, const MjcfPosedBodies& posed, MjcfScene& scene) {
  std::set<const MjcfElement*> copied;
  size_t checks = 0;
  for (size_t i = 0; i < tree.copies.size(); ++i) {
    TendonReader reader(tree.copies[i], tree, posed, scene);
    const bool is_model = i == 0;
    for (const MjcfElement* tendon : tendons_of(*tree.copies[i].source)) {
      if (scene.tendons.size() == kMaxTendons || ++checks > kMaxChecks) return;
      if (tendon->kind == "spatial" ? !reader.holds(*tendon) : !is_model) continue;
      copied.insert(tendon);
      reader.read(*tendon);
    }
  }
  if (tree.copies.empty()) return;
  MjcfSource& model = *tree.copies.front().source;
  for (const MjcfElement* tendon : tendons_of(model))
    if (!copied.contains(tendon))
      model.messages().warn(tendon->where() + " is left out: a site of it does not exist");
}

}  // namespace fire3dv::convert
