#include "convert/mjcf/deformable/mjcf_skins.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "convert/mjcf/deformable/skin_data.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxSkins = 10'000, kMaxVertices = 20'000'000;

Result<SkinData> read_data(const MjcfSource& source, const MjcfElement& element) {
  const std::string name = source.file_name(element.text("file"));
  if (name.empty()) return parse_inline_skin(element);
  const Result<fs::path> file =
      source.files().find(name, source.folders(element, source.compiler().mesh_folder));
  if (!file) return file.error();
  std::string extension = file->extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension != ".skn") return Error{quote(file->string()) + " is no SKN file"};
  const Result<FileBytes> bytes = source.files().read(*file);
  if (!bytes) return bytes.error();
  Result<SkinData> data =
      parse_skn({reinterpret_cast<const char*>(bytes->view().data()), bytes->view().size()});
  if (!data) return Error{quote(file->string()) + ": " + data.error().message};
  return data;
}

class SkinReader {
 public:
  SkinReader(const MjcfTree& tree, const MjcfPosedBodies& posed, MjcfScene& scene)
      : tree_(tree), posed_(posed), scene_(scene) {}

  void read(const MjcfCopy& copy, const MjcfElement& element, bool is_model) {
    const MjcfSource& source = *copy.source;
    Read& read = data_[&element];
    if (!std::exchange(read.is_read, true)) {
      Result<SkinData> data = read_data(source, element);
      if (data)
        read.data = std::make_unique<SkinData>(std::move(*data));
      else
        leave_out(source, element, data.error().message);
    }
    if (!read.data) return;
    // Bodies of replicas have other names than those that a skin knows.
    const SkinData::Bone* const lost = missing_bone(copy, *read.data);
    if (!lost)
      add(copy, element, *read.data);
    else if (is_model)
      leave_out(source, element, "there is no body " + quote(lost->body));
  }

 private:
  struct Read {
    bool is_read = false;
    std::unique_ptr<SkinData> data;  // null: left out
  };

  static void leave_out(const MjcfSource& source, const MjcfElement& element, const std::string& reason) {
    source.messages().warn(element.where() + " is left out: " + reason);
  }

  static std::string name_in_copy(const MjcfCopy& copy, const std::string& own) {
    return copy.prefix + own + copy.suffix;
  }

  const SkinData::Bone* missing_bone(const MjcfCopy& copy, const SkinData& data) const {
    const auto lost = std::find_if(data.bones.begin(), data.bones.end(), [&](const SkinData::Bone& bone) {
      return !tree_.body_index.contains(name_in_copy(copy, bone.body));
    });
    return lost == data.bones.end() ? nullptr : &*lost;
  }

  void add(const MjcfCopy& copy, const MjcfElement& element, const SkinData& data) {
    MjcfSource& source = *copy.source;
    vertices_ += data.vertices.size();
    if (scene_.skins.size() == kMaxSkins || vertices_ > kMaxVertices)
      return leave_out(source, element,
                       "the model has more than " + std::to_string(kMaxSkins) + " skins, or " +
                           std::to_string(kMaxVertices) + " vertices of them");
    const MjcfAttributes from = source.attributes(element, MjcfDefaults::kMain);
    const double inflation = from.number("inflate", 0);
    Result<BoundSkin> bound = bind_skin(data, inflation);
    if (!bound) return leave_out(source, element, bound.error().message);
    if (!bound->has_all_bones)
      from.warn(
          "a vertex follows more than eight bodies, or has a negative weight: its eight greatest weights "
          "are used");
    MjcfSkin skin;
    skin.name = name_in_copy(copy, name_of(element));
    skin.group = from.integer("group", 0);
    if (const auto rgba = from.vec4("rgba"))
      for (int i = 0; i < 4; ++i) skin.rgba[static_cast<size_t>(i)] = static_cast<float>((*rgba)[i]);
    if (const std::string material = from.text("material"); !material.empty())
      skin.material = source.material(material, element, scene_);
    for (const SkinData::Bone& bone : data.bones)
      skin.bones.push_back(
          {tree_.body_index.find(name_in_copy(copy, bone.body))->second, {bone.position, bone.rotation}});
    skin.surface = std::move(bound->surface);
    if (bound->is_rigid) {
      skin.surface.positions = data.vertices;
      bind_to_pose(posed_, inflation, skin);
    }
    scene_.skins.push_back(std::move(skin));
  }

  static std::string name_of(const MjcfElement& element) {
    const std::string name = element.text("name");
    return name.empty() ? fs::path(element.text("file")).stem().string() : name;
  }

  const MjcfTree& tree_;
  const MjcfPosedBodies& posed_;
  MjcfScene& scene_;
  std::map<const MjcfElement*, Read> data_;
  size_t vertices_ = 0;
};

}  // namespace

void bind_to_pose(const MjcfPosedBodies& posed, double inflation, MjcfSkin& skin) {
  Surface& surface = skin.surface;
  std::vector<MjcfPose> world_from_mesh;
  for (MjcfSkin::Bone& bone : skin.bones) {
    const MjcfPose& body = posed.bodies[bone.body];
    const glm::dquat rotation = body.rotation * glm::conjugate(bone.bind.rotation);
    world_from_mesh.push_back({body.position - rotation * bone.bind.position, rotation});
    bone.bind = body;
  }
  for (size_t v = 0; v < surface.positions.size(); ++v) {
    const Influences& influences = surface.influences[v];
    const auto at = std::max_element(influences.weights.begin(), influences.weights.end());
    const uint16_t bone = influences.joints[static_cast<size_t>(at - influences.weights.begin())];
    surface.positions[v] = glm::vec3(world_from_mesh[bone] * glm::dvec3(surface.positions[v]));
  }
  inflate(inflation, surface);
}

void add_skins(const MjcfTree& tree, const MjcfPosedBodies& posed, MjcfScene& scene) {
  SkinReader reader(tree, posed, scene);
  std::set<std::pair<const MjcfElement*, std::string>> known;  // copies may share their affixes
  for (size_t i = 0; i < tree.copies.size(); ++i) {
    const MjcfCopy& copy = tree.copies[i];
    for (const MjcfElement& section : copy.source->root().children) {
      if (section.kind != "asset" && section.kind != "deformable") continue;
      for (const MjcfElement& element : section.children)
        if (element.kind == "skin" && known.emplace(&element, copy.prefix + '\n' + copy.suffix).second)
          reader.read(copy, element, i == 0);
    }
  }
}

}  // namespace fire3dv::convert
