// Reader for URDF: one node per link, below the parent link of its joint, with all visuals of the link.
// Joints are at 0, or at the nearest limit; those that mimic others follow them.
#include <console_bridge/console.h>
#include <tinyxml2.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "convert/description_files.h"
#include "convert/mesh/mesh_files.h"
#include "convert/mesh/mesh_store.h"
#include "convert/model.h"
#include "convert/readers.h"
#include "convert/surfaces.h"
#include "convert/urdf/urdf_joints.h"
#include "convert/urdf/urdf_repair.h"
#include "convert/urdf_files.h"
#include "convert/xacro/xacro.h"
#include "convert/xacro/xacro_program.h"
#include "convert/xml_error.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;
constexpr size_t kMaxLinks = 20'000;

// Captures urdfdom's messages. Its output handler is per process, hence the mutex.
std::mutex handler_mutex;
class Messages : public console_bridge::OutputHandler {
 public:
  Messages() { console_bridge::useOutputHandler(this); }
  ~Messages() override { console_bridge::restorePreviousOutputHandler(); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && errors.size() < 3) errors.push_back(text);
  }
  std::vector<std::string> errors;
};

glm::dvec3 vec3(const urdf::Vector3& v) {
  return {v.x, v.y, v.z};
}
glm::dquat quat(const urdf::Rotation& r) {
  return {r.w, r.x, r.y, r.z};
}

// Returns a link of a kinematic loop, if any: urdfdom's links would own each other in a cycle.
std::optional<std::string> link_of_a_loop(const tinyxml2::XMLElement& robot) {
  std::map<std::string, std::vector<std::string>> children;
  std::map<std::string, size_t> parents;  // number of unvisited parents
  for (const tinyxml2::XMLElement* joint = robot.FirstChildElement("joint"); joint;
       joint = joint->NextSiblingElement("joint")) {
    const tinyxml2::XMLElement* parent = joint->FirstChildElement("parent");
    const tinyxml2::XMLElement* child = joint->FirstChildElement("child");
    const char* from = parent ? parent->Attribute("link") : nullptr;
    const char* to = child ? child->Attribute("link") : nullptr;
    if (!from || !to) continue;
    children[from].emplace_back(to);
    parents.try_emplace(from, 0);
    ++parents[to];
  }
  std::vector<std::string> free;
  for (const auto& [name, count] : parents)
    if (count == 0) free.push_back(name);
  for (size_t i = 0; i < free.size(); ++i) {
    for (const std::string& child : children[free[i]])
      if (--parents[child] == 0) free.push_back(child);
  }
  for (const auto& [name, count] : parents)
    if (count > 0) return name;
  return std::nullopt;
}

// warnings: receives what was repaired. joint_names: receives the order of the file, which urdfdom loses.
Result<urdf::ModelInterfaceSharedPtr> parse(const fs::path& file, std::string text,
                                            std::vector<std::string>& warnings,
                                            std::vector<std::string>& joint_names) {
  const std::string name = quote(file.string());
  tinyxml2::XMLDocument document;  // locates syntax errors, which urdfdom does not
  if (document.Parse(text.c_str()) != tinyxml2::XML_SUCCESS) return Error{name + ", " + xml_error(document)};
  if (tinyxml2::XMLElement* robot_element = document.RootElement()) {
    if (const std::optional<std::string> link = link_of_a_loop(*robot_element))
      return Error{name + ": link " + quote(*link) + " hangs on itself by its joints, in a loop"};
    for (const std::string& note : repair_urdf(*robot_element, file.stem().string()))
      warnings.push_back(file.string() + ": " + note);
    for (const tinyxml2::XMLElement* joint = robot_element->FirstChildElement("joint"); joint;
         joint = joint->NextSiblingElement("joint"))
      if (const char* joint_name = joint->Attribute("name")) joint_names.emplace_back(joint_name);
    tinyxml2::XMLPrinter printer(nullptr, true);
    document.Print(&printer);
    text = printer.CStr();
  }
  size_t links = 0;
  for (size_t at = text.find("<link"); at != std::string::npos; at = text.find("<link", at + 5)) ++links;
  if (links > kMaxLinks)
    return Error{name + " has more than " + std::to_string(kMaxLinks) + " links: split it"};

  const std::lock_guard lock(handler_mutex);
  Messages messages;
  urdf::ModelInterfaceSharedPtr model;
  try {
    model = urdf::parseURDF(text);
  } catch (const std::exception& fault) {
    return Error{name + ": " + fault.what()};
  }
  if (model && model->getRoot()) {
    for (std::string& lost : messages.errors) {
      std::replace(lost.begin(), lost.end(), '\n', ' ');
      warnings.push_back(file.string() + ": " + sanitize_text(lost));
    }
    return model;
  }
  std::string why = "no robot is found in it";
  if (!messages.errors.empty()) {
    why = messages.errors.front();
    std::replace(why.begin(), why.end(), '\n', ' ');
  }
  return Error{name + ": " + why};
}

class Reader {
 public:
  Reader(const fs::path& file, const ReadOptions& options, UrdfFiles& files, Model& model)
      : file_(file), files_(files), mesh_files_(model), meshes_(model, options.max_triangles), model_(model) {
    if (options.dae_up) mesh_files_.apply_dae_up();
    mesh_files_.set_smooth_angle(options.smooth_angle_deg);
    if (options.gltf_up.value_or(true)) mesh_files_.apply_gltf_up();
  }

  void read(const urdf::ModelInterface& robot, const std::vector<std::string>& joint_names) {
    std::map<std::string, size_t> node_of_link;
    std::vector<std::pair<const urdf::Link*, std::optional<size_t>>> links{
        {robot.getRoot().get(), std::nullopt}};
    std::set<const urdf::Link*> seen;
    for (size_t i = 0; i < links.size(); ++i) {
      const auto [link, parent] = links[i];
      if (!seen.insert(link).second) continue;
      const size_t index = model_.nodes.size();
      add_link(*link, parent);
      node_of_link.emplace(link->name, index);
      for (const urdf::LinkSharedPtr& child : link->child_links) links.emplace_back(child.get(), index);
    }
    for (const auto& [name, link] : robot.links_) {
      if (!seen.contains(link.get()))
        warn("link \"" + name + "\" hangs on no joint that leads to " + quote(robot.getRoot()->name));
    }
    std::vector<std::string> warnings;
    add_urdf_joints(robot, joint_names, node_of_link, model_, warnings);
    for (const std::string& warning : warnings) warn(warning);
    if (const std::string invisible = describe_invisible(model_); !invisible.empty())
      warn("link " + invisible + ", as in RViz");
    warn_if_nothing_is_drawn(robot);
  }

 private:
  void warn_if_nothing_is_drawn(const urdf::ModelInterface& robot) {
    if (!model_.meshes.empty()) return;
    size_t collisions = 0;
    for (const auto& [name, link] : robot.links_) collisions += link->collision_array.size();
    if (visuals_ == 0) {
      warn("nothing to draw: no link has a <visual>" +
           (collisions > 0 ? ", only <collision>, which is not drawn: copy the shapes to <visual>"
                           : std::string("; was the file made for kinematics only?")));
    } else if (missing_meshes_ == visuals_) {
      warn("nothing to draw: " +
           (visuals_ == 1 ? "its only mesh is" : "all " + std::to_string(visuals_) + " meshes are") +
           " missing (see above); name the folder that holds the packages with --package-path");
    } else {
      warn("nothing to draw: none of its " + std::to_string(visuals_) + " visuals can be read (see above)");
    }
  }

  void warn(const std::string& text) { model_.warnings.push_back(file_.string() + ": " + text); }

  Result<fs::path> resolve(const std::string& uri) {
    Result<fs::path> path = files_.resolve(uri, model_.sources);
    for (const std::string& note : files_.take_notes()) warn(note);
    return path;
  }

  void add_link(const urdf::Link& link, std::optional<size_t> parent) {
    const urdf::Joint* joint = link.parent_joint.get();
    Node node;
    node.name = link.name;
    node.parent = parent;
    if (joint) {  // at 0; add_urdf_joints moves it to where it rests
      const urdf::Pose& origin = joint->parent_to_joint_origin_transform;
      node.translation = vec3(origin.position);
      node.rotation = quat(origin.rotation);
    }
    node.mesh = mesh_of(link);
    model_.nodes.push_back(std::move(node));
  }

  std::optional<size_t> mesh_of(const urdf::Link& link) {
    Mesh mesh;
    mesh.name = link.name;
    for (const urdf::VisualSharedPtr& visual : link.visual_array) {
      if (!visual || !visual->geometry) continue;
      ++visuals_;
      if (!meshes_.take_shape(mesh)) {
        if (!std::exchange(said_full_, true))
          warn("link " + quote(link.name) + " and those after it lack visuals: " + meshes_.why_full());
        break;
      }
      add_visual(*visual, link, mesh);
    }
    return meshes_.add(std::move(mesh));
  }

  void add_visual(const urdf::Visual& visual, const urdf::Link& link, Mesh& mesh) {
    const glm::dmat4 transform = matrix_of(vec3(visual.origin.position), quat(visual.origin.rotation));
    const std::optional<size_t> own = material_of(visual);
    const auto add = [&](const Surface& surface) {
      add_surface(mesh, surface, transform, own ? *own : plain_material());
    };
    switch (visual.geometry->type) {
      case urdf::Geometry::BOX:
        return add(box(vec3(static_cast<const urdf::Box&>(*visual.geometry).dim) / 2.0));
      case urdf::Geometry::SPHERE:
        return add(ellipsoid(glm::dvec3(static_cast<const urdf::Sphere&>(*visual.geometry).radius)));
      case urdf::Geometry::CYLINDER: {
        const auto& shape = static_cast<const urdf::Cylinder&>(*visual.geometry);
        return add(cylinder(shape.radius, shape.length / 2));
      }
      case urdf::Geometry::MESH:
        break;
    }
    add_mesh(static_cast<const urdf::Mesh&>(*visual.geometry), link, transform, own, mesh);
  }

  void add_mesh(const urdf::Mesh& shape, const urdf::Link& link, const glm::dmat4& transform,
                std::optional<size_t> own, Mesh& mesh) {
    const std::string where = "link \"" + link.name + "\": ";
    const Result<fs::path> path = resolve(shape.filename);
    if (!path || !regular_file(*path)) ++missing_meshes_;
    if (!path) return warn(where + path.error().message);
    mesh_files_.allow_images_below(files_.image_folders());
    const Result<std::vector<Surface>> surfaces = mesh_files_.surfaces(*path);
    if (!surfaces) return warn(where + surfaces.error().message);
    const glm::dvec3 scale = vec3(shape.scale);
    if (scale.x == 0 || scale.y == 0 || scale.z == 0) return warn(where + "a scale of 0 is invisible");
    glm::dmat4 scaled = transform;
    for (int axis = 0; axis < 3; ++axis) scaled[axis] *= scale[axis];
    for (const Surface& surface : *surfaces)
      add_surface(mesh, surface, scaled,
                  own && mesh_files_.is_default(surface.material) ? *own : surface.material);
  }

  // Returns the URDF's material, if any. It applies to meshes without materials, as in RViz.
  std::optional<size_t> material_of(const urdf::Visual& visual) {
    if (!visual.material) return std::nullopt;
    const urdf::Color& color = visual.material->color;
    const std::string& texture = visual.material->texture_filename;
    const auto [known, is_new] = materials_.try_emplace(
        {visual.material->name, texture, color.r, color.g, color.b, color.a}, model_.materials.size());
    if (!is_new) return known->second;
    Material made;
    made.name = visual.material->name;
    if (!texture.empty()) made.base_color_image = image(texture);
    // urdfdom's default colour is black and would hide a texture without a colour.
    const bool no_color = !texture.empty() && color.r == 0 && color.g == 0 && color.b == 0;
    made.base_color =
        no_color ? glm::vec4(1) : linear_from_srgb(glm::vec4{color.r, color.g, color.b, color.a});
    made.blended = made.base_color.a < 1;
    model_.materials.push_back(std::move(made));
    return known->second;
  }

  std::optional<size_t> image(const std::string& uri) {
    const std::string where = "texture " + quote(uri) + ": ";
    const auto left_out = [&](const std::string& why) {
      warn(where + why);
      return std::nullopt;
    };
    const Result<fs::path> path = resolve(uri);
    if (!path) return left_out(path.error().message);
    const Result<fs::path> file = regular_file(*path);
    if (!file) return left_out(file.error().message);
    if (!files_.image_folders().hold(*file))
      return left_out(
          "it lies outside the folders of the URDF, of its packages (by their package.xml) and of "
          "--package-path; copy it next to the URDF, or name its folder with --package-path");
    if (const auto known = images_.find(*file); known != images_.end()) return known->second;
    constexpr uint64_t kMaxBytes = uint64_t{1} << 30;
    const Result<FileBytes> bytes = read_asset(*file, kMaxBytes);
    if (!bytes) return left_out(bytes.error().message);
    images_[*file] = model_.images.size();
    model_.images.push_back({file->filename().string(), {bytes->view().begin(), bytes->view().end()}});
    return model_.images.size() - 1;
  }

  size_t plain_material() {
    if (!plain_) {
      plain_ = model_.materials.size();
      model_.materials.push_back({});
      model_.materials.back().name = "plain";
      model_.materials.back().base_color = {0.6f, 0.6f, 0.6f, 1};
    }
    return *plain_;
  }

  const fs::path file_;
  UrdfFiles& files_;
  MeshFiles mesh_files_;
  MeshStore meshes_;
  Model& model_;
  // Materials by name, texture and colour, since links repeat their definitions.
  std::map<std::tuple<std::string, std::string, float, float, float, float>, size_t> materials_;
  std::map<fs::path, size_t> images_;
  std::optional<size_t> plain_;
  size_t visuals_ = 0, missing_meshes_ = 0;
  bool said_full_ = false;
};

// Unlinks the links, whose recursive destruction would overflow the stack on a long chain.
void take_apart(urdf::ModelInterface& robot) {
  for (const auto& [name, link] : robot.links_) {
    link->child_links.clear();
    link->child_joints.clear();
  }
}

// Returns the text, expanded if it is xacro.
Result<std::string> expanded_text(const fs::path& file, const ReadOptions& options, UrdfFiles& files,
                                  Sources& sources, std::vector<std::string>& warnings) {
  Result<std::string> text = read_text(file);
  if (!text) return text;
  if (!has_xacro_element(*text) && file.extension() != ".xacro") return text;
  if (options.xacro_program.empty()) {
    Result<ExpandedXacro> expanded = expand_xacro(file, *text, options.xacro_arguments, files, sources);
    if (!expanded) return expanded.error();
    for (const std::string& warning : expanded->warnings) warnings.push_back(file.string() + ": " + warning);
    text = std::move(expanded->text);
  } else {
    text = run_xacro_program(options.xacro_program, file, options.xacro_arguments);
    if (!text) return text;
  }
  // The guard of the XML readers holds for the result, too.
  if (const Result<std::string> root = xml_root(*text); !root)
    return Error{quote(file.string()) + ", expanded, " + root.error().message};
  return text;
}

}  // namespace

Result<std::string> read_urdf_text(const std::filesystem::path& file, const ReadOptions& options,
                                   std::vector<std::string>& warnings) {
  Sources sources;
  UrdfFiles files(file, options.package_folders, options.is_confined, sources);
  return expanded_text(file, options, files, sources, warnings);
}

Result<Model> read_urdf(const std::filesystem::path& file, const ReadOptions& options) {
  Model model;
  model.sources.add(file);
  UrdfFiles files(file, options.package_folders, options.is_confined, model.sources);
  const Result<std::string> text = expanded_text(file, options, files, model.sources, model.warnings);
  if (!text) return text.error();
  std::vector<std::string> joint_names;
  Result<urdf::ModelInterfaceSharedPtr> robot = parse(file, *text, model.warnings, joint_names);
  if (!robot) return robot.error();
  model.view_from = kThreeQuarterFront;
  model.name = (*robot)->getName().empty() ? file.stem().string() : (*robot)->getName();
  Reader(file, options, files, model).read(**robot, joint_names);
  take_apart(**robot);
  return model;
}

}  // namespace fire3dv::convert
