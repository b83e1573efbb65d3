#include "convert/adf/adf_visual.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <sstream>

#include "convert/description_files.h"
#include "convert/model.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {

namespace {

constexpr uint32_t kSides = 32, kStacks = 32;  // AMBF's tessellation, for equal silhouettes
constexpr double kPlaneSize = 100;

uint32_t vertex(Surface& s, const glm::dvec3& position, const glm::dvec3& normal) {
  s.positions.emplace_back(position);
  s.normals.emplace_back(glm::normalize(normal));
  return static_cast<uint32_t>(s.positions.size() - 1);
}

void triangle(Surface& s, uint32_t a, uint32_t b, uint32_t c) {
  s.indices.insert(s.indices.end(), {a, b, c});
}

// Quad around `centre`, spanned by u and v, with normal u x v.
void quad(Surface& s, const glm::dvec3& centre, const glm::dvec3& u, const glm::dvec3& v) {
  const glm::dvec3 normal = glm::cross(u, v);
  const uint32_t a = vertex(s, centre - u - v, normal), b = vertex(s, centre + u - v, normal),
                 c = vertex(s, centre + u + v, normal), d = vertex(s, centre - u + v, normal);
  triangle(s, a, b, c);
  triangle(s, a, c, d);
}

glm::dvec2 around(uint32_t side) {
  const double angle = glm::two_pi<double>() * (side % kSides) / kSides;
  return {std::cos(angle), std::sin(angle)};
}

void disc(Surface& s, double z, double radius, double up) {
  if (radius <= 0) return;
  const uint32_t center = vertex(s, {0, 0, z}, {0, 0, up});
  uint32_t last = 0;
  for (uint32_t i = 0; i <= kSides; ++i) {
    const uint32_t next = vertex(s, {radius * around(i), z}, {0, 0, up});
    if (i > 0 && up > 0) triangle(s, center, last, next);
    if (i > 0 && up < 0) triangle(s, center, next, last);
    last = next;
  }
}

}  // namespace

Surface box_surface(const glm::dvec3& full_extents) {
  const glm::dvec3 h = 0.5 * full_extents;
  Surface s;
  if (!(h.x > 0 && h.y > 0 && h.z > 0)) return s;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 w(0), u(0), v(0);
    w[axis] = h[axis];
    u[(axis + 1) % 3] = h[(axis + 1) % 3];
    v[(axis + 2) % 3] = h[(axis + 2) % 3];
    quad(s, w, u, v);
    quad(s, -w, v, u);
  }
  return s;
}

Surface ellipsoid_surface(const glm::dvec3& semi_axes) {
  Surface s;
  if (!(semi_axes.x > 0 && semi_axes.y > 0 && semi_axes.z > 0)) return s;
  for (uint32_t stack = 0; stack <= kStacks; ++stack) {
    const double angle = glm::pi<double>() * stack / kStacks;
    for (uint32_t side = 0; side <= kSides; ++side) {
      const glm::dvec3 sphere(std::sin(angle) * around(side), -std::cos(angle));
      vertex(s, sphere * semi_axes, sphere / semi_axes);
      if (stack == 0 || side == 0) continue;
      const uint32_t d = static_cast<uint32_t>(s.positions.size() - 1), c = d - 1, b = d - kSides - 1,
                     a = b - 1;
      if (stack > 1) triangle(s, a, b, d);  // at the poles one of the two triangles is degenerate
      if (stack < kStacks) triangle(s, a, d, c);
    }
  }
  return s;
}

Surface cylinder_surface(double height, double bottom_radius, double top_radius) {
  Surface s;
  if (!(height > 0 && bottom_radius > 0)) return s;
  for (uint32_t side = 0; side <= kSides; ++side) {
    const glm::dvec2 at = around(side);
    const glm::dvec3 normal(at * height, bottom_radius - top_radius);
    vertex(s, {bottom_radius * at, -0.5 * height}, normal);
    vertex(s, {top_radius * at, 0.5 * height}, normal);
    if (side == 0) continue;
    const uint32_t d = static_cast<uint32_t>(s.positions.size() - 1), b = d - 1, c = d - 2, a = d - 3;
    triangle(s, a, b, d);
    if (top_radius > 0) triangle(s, a, d, c);
  }
  disc(s, -0.5 * height, bottom_radius, -1);
  disc(s, 0.5 * height, top_radius, 1);
  return s;
}

Surface plane_surface(const glm::dvec3& normal, double offset) {
  Surface s;
  const double length = glm::length(normal);
  if (!(length > 0)) return s;
  const glm::dvec3 n = normal / length;
  // Axes of the shortest rotation from Z to n, so that the square's edges match AMBF's.
  const double f = n.z > -0.999999 ? 1 / (1 + n.z) : 0;
  const glm::dvec3 u = f > 0 ? glm::dvec3(1 - f * n.x * n.x, -f * n.x * n.y, -n.x) : glm::dvec3(1, 0, 0);
  const glm::dvec3 v = glm::cross(n, u);
  quad(s, offset * normal, u * (0.5 * kPlaneSize), v * (0.5 * kPlaneSize));
  return s;
}

namespace {

constexpr size_t kMaxParts = 1000;

// Converts a Blinn-Phong exponent to the roughness with equal highlight width.
float roughness_of(double shininess, const glm::dvec3& specular) {
  if (specular == glm::dvec3(0)) return 1;
  return static_cast<float>(std::sqrt(2 / (std::clamp(shininess, 0.0, 128.0) + 2)));
}

std::string exact(double value) {
  std::ostringstream text;
  text << std::hexfloat << value << ' ';
  return text.str();
}

bool finite(const Surface& surface) {
  return std::all_of(surface.positions.begin(), surface.positions.end(), [](const glm::vec3& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  });
}

}  // namespace

struct AdfVisuals::Color {
  bool used = false;  // false: the mesh keeps its own materials
  glm::dvec3 diffuse{0.7}, specular{1}, emission{0};
  double opacity = 1, shininess = 64;

  std::string key() const {
    if (!used) return "-";
    std::string text;
    for (const glm::dvec3& c : {diffuse, specular, emission})
      for (int i = 0; i < 3; ++i) text += exact(c[i]);
    return text + exact(opacity) + exact(shininess);
  }
};

AdfVisuals::Color AdfVisuals::color_of(const AdfValue& block) const {
  Color color;
  const AdfValue rgba = block["color rgba"], components = block["color components"];
  if (rgba.is_map()) {
    color.diffuse = rgba.vector(color.diffuse, "rgb");
    color.opacity = rgba["a"].number(1);
  } else if (components.is_map()) {
    color.diffuse = components["diffuse"].vector(color.diffuse, "rgb");
    color.specular = components["specular"].vector(color.specular, "rgb");
    color.emission = components["emission"].vector(color.emission, "rgb");
    color.shininess = components["shininess"].number(color.shininess);
    if (!components["transparency"].is_defined())
      components.warn("has no \"transparency\" (1 is opaque), without which AMBF does not load the file");
    color.opacity = components["transparency"].number(1);
  } else {
    return color;
  }
  color.opacity = std::clamp(color.opacity, 0.0, 1.0);
  color.used = block["use material"].flag(true);
  return color;
}

AdfAppearance AdfVisuals::appearance_of(const AdfValue& block, const std::string& name,
                                        const AdfSearchPaths& search_paths) {
  AdfAppearance appearance;
  const Color color = color_of(block);
  // AMBF reads "visible" only where it sets the colour.
  if (color.used && !block["visible"].flag(true)) return appearance;
  if (store_.is_full()) {  // a short file may request one large mesh in thousands of scales
    block.warn("has no mesh, nor have those after it: " + store_.why_full());
    return appearance;
  }
  const double scale = block["scale"].number(1);
  const AdfValue shape = block["shape"], compound = block["compound shape"], mesh = block["mesh"];
  std::vector<Surface> surfaces;
  std::string key;
  if (shape.is_defined() || compound.is_defined()) {
    surfaces = shape_surfaces(block, scale);
  } else if (!mesh.text().empty()) {
    key = mesh.text() + '\n' + block["high resolution path"].text() + '\n' + search_paths.visual_path + '\n' +
          search_paths.file_folder.string() + '\n' + exact(scale) + color.key();
    if (const auto found = meshes_.find(key); found != meshes_.end()) {
      appearance.mesh = found->second;
      appearance.mesh_is_missing = !found->second;
      if (!found->second)
        mesh.warn("of " + quote(name) + " is left out, and its node stays without one, as before");
      return appearance;
    }
    std::optional<std::vector<Surface>> read = file_surfaces(block, name, search_paths, scale);
    if (!read) {
      meshes_[key] = std::nullopt;
      appearance.mesh_is_missing = true;
      return appearance;
    }
    surfaces = std::move(*read);
  }
  std::erase_if(surfaces, [](const Surface& s) { return s.indices.empty(); });
  if (color.used)
    for (Surface& surface : surfaces) surface.material = colored(surface.material, color, name);
  appearance.mesh = store_.add({sanitize_text(name), std::move(surfaces)});
  if (!key.empty() && appearance.mesh) meshes_[key] = appearance.mesh;
  return appearance;
}

std::optional<std::vector<Surface>> AdfVisuals::file_surfaces(const AdfValue& block, const std::string& name,
                                                              const AdfSearchPaths& search_paths,
                                                              double scale) {
  const AdfValue mesh = block["mesh"];
  const std::filesystem::path own = block["high resolution path"].text();
  const std::filesystem::path named = own / mesh.text();
  // AMBF appends the block's path to the file's; some files mean the block's path alone.
  std::vector<std::filesystem::path> candidates{search_paths.file_folder / search_paths.visual_path / named};
  if (!own.empty()) candidates.push_back(search_paths.file_folder / named);
  model_.sources.add(candidates[0]);
  std::error_code error;
  const bool first = candidates.size() == 1 || std::filesystem::exists(candidates[0], error);
  const std::filesystem::path file = tidy_path(first ? candidates[0] : candidates[1]);
  files_.allow_images_below(file.parent_path());
  Result<std::vector<Surface>> surfaces = files_.surfaces(file, glm::dvec3(scale));
  if (surfaces) return std::move(*surfaces);
  mesh.warn("of " + quote(name) +
            " is left out, and its node stays without one: " + surfaces.error().message);
  return std::nullopt;
}

std::vector<Surface> AdfVisuals::shape_surfaces(const AdfValue& block, double scale) {
  std::vector<Surface> surfaces;
  if (block["shape"].is_defined()) {
    surfaces.push_back(shape_surface(block["shape"], block["geometry"], scale));
  } else {
    // AMBF draws all parts at the body's origin; "offset" affects collision shapes only.
    for (const AdfValue& part : block["compound shape"].items(kMaxParts))
      surfaces.push_back(shape_surface(part["shape"], part["geometry"], scale));
  }
  const size_t plain = plain_material();
  for (Surface& surface : surfaces) surface.material = plain;
  return surfaces;
}

Surface AdfVisuals::shape_surface(const AdfValue& shape, const AdfValue& geometry, double scale) {
  if (!store_.take_shape({})) {
    shape.warn("and further shapes are left out: " + store_.why_full());
    return {};
  }
  std::string kind = shape.text();
  std::transform(kind.begin(), kind.end(), kind.begin(), [](unsigned char c) { return std::toupper(c); });
  const double radius = geometry["radius"].number(0) * scale, height = geometry["height"].number(0) * scale;
  Surface surface;
  if (kind == "BOX")
    surface = box_surface(geometry.vector(glm::dvec3(0)) * scale);
  else if (kind == "SPHERE")
    surface = ellipsoid_surface(glm::dvec3(radius));
  else if (kind == "CAPSULE")
    surface = ellipsoid_surface({radius, radius, height});  // AMBF draws capsules as ellipsoids
  else if (kind == "CYLINDER")
    surface = cylinder_surface(height, radius, radius);
  else if (kind == "CONE")
    surface = cylinder_surface(height, radius, 0);
  else if (kind == "PLANE") {
    surface = plane_surface(geometry["normal"].vector(glm::dvec3(0)), geometry["offset"].number(0));
    for (glm::vec3& position : surface.positions) position *= static_cast<float>(scale);
  } else {
    shape.warn("is none of BOX, SPHERE, CYLINDER, CONE, CAPSULE and PLANE; nothing is drawn for it");
    return surface;
  }
  if (surface.indices.empty() || !finite(surface)) {
    shape.warn("has no size that can be drawn");
    return {};
  }
  return surface;
}

size_t AdfVisuals::colored(size_t material, const Color& color, const std::string& name) {
  const std::optional<size_t> image = model_.materials[material].base_color_image,
                              normals = model_.materials[material].normal_image;
  const std::string key =
      color.key() + std::to_string(image ? *image + 1 : 0) + ' ' + std::to_string(normals ? *normals + 1 : 0);
  const auto [found, is_new] = materials_.try_emplace(key, model_.materials.size());
  if (!is_new) return found->second;
  Material to;
  to.name = sanitize_text(name);
  to.base_color = glm::vec4(linear_from_srgb(color.diffuse), color.opacity);
  to.emission = linear_from_srgb(color.emission);
  to.roughness = roughness_of(color.shininess, color.specular);
  to.blended = color.opacity < 1;
  // The block's colour replaces the material, but keeps its textures.
  to.base_color_image = image;
  to.normal_image = normals;
  model_.materials.push_back(std::move(to));
  return found->second;
}

size_t AdfVisuals::plain_material() {
  if (!plain_) {
    Material plain;
    plain.name = "plain";
    plain.base_color = glm::vec4(linear_from_srgb(glm::vec3(0.7f)), 1);
    plain.roughness = roughness_of(64, glm::dvec3(1));
    model_.materials.push_back(std::move(plain));
    plain_ = model_.materials.size() - 1;
  }
  return *plain_;
}

}  // namespace fire3dv::convert
