#include "convert/mjcf/deformable/skin_data.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include "base/text.h"
#include "convert/mjcf/xml/mjcf_attributes.h"

namespace fire3dv::convert {
namespace {

constexpr size_t kMaxSkinNumbers = 60'000'000, kMaxSkinBones = 65'535;
constexpr float kMaxSkinCoordinate = 1 << 30;
constexpr double kMinWeight = 1e-15;

bool is_in_bounds(const glm::vec3& v) {
  return std::abs(v.x) <= kMaxSkinCoordinate && std::abs(v.y) <= kMaxSkinCoordinate &&
         std::abs(v.z) <= kMaxSkinCoordinate;
}

Result<void> check_bone(SkinData::Bone& bone, size_t vertices) {
  const Error wrong{"the bone " + quote(bone.body)};
  const double length = glm::length(bone.rotation);
  if (!is_in_bounds(glm::vec3(bone.position)) || !std::isfinite(length))
    return Error{wrong.message + " has a bind pose that is not finite, or beyond 2^30"};
  bone.rotation = length > 1e-14 ? bone.rotation / length : glm::dquat(1, 0, 0, 0);
  if (bone.vertices.empty() || bone.vertices.size() != bone.weights.size())
    return Error{wrong.message + " has " + std::to_string(bone.vertices.size()) + " vertices and " +
                 std::to_string(bone.weights.size()) + " weights"};
  for (const uint32_t vertex : bone.vertices)
    if (vertex >= vertices)
      return Error{wrong.message + " names vertex " + std::to_string(vertex) + " of " +
                   std::to_string(vertices) + ", counted from 0"};
  for (const float weight : bone.weights)
    if (!std::isfinite(weight)) return Error{wrong.message + " has a weight that is not finite"};
  return {};
}

Result<SkinData> checked(SkinData data) {
  if (data.vertices.empty() || data.faces.empty() || data.bones.empty())
    return Error{"it lacks vertices, faces or bones"};
  if (data.bones.size() > kMaxSkinBones)
    return Error{"it has more than " + std::to_string(kMaxSkinBones) + " bones"};
  if (!data.uvs.empty() && data.uvs.size() != data.vertices.size())
    return Error{"it has " + std::to_string(data.uvs.size()) + " texture coordinates for " +
                 std::to_string(data.vertices.size()) + " vertices"};
  if (!std::all_of(data.vertices.begin(), data.vertices.end(), is_in_bounds))
    return Error{"a vertex is not finite, or beyond 2^30"};
  for (glm::vec2& uv : data.uvs)
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) uv = glm::vec2(0);
  for (const auto& face : data.faces)
    for (const uint32_t corner : face)
      if (corner >= data.vertices.size())
        return Error{"a face names vertex " + std::to_string(corner) + " of " +
                     std::to_string(data.vertices.size()) + ", counted from 0"};
  for (SkinData::Bone& bone : data.bones)
    if (Result<void> done = check_bone(bone, data.vertices.size()); !done) return done.error();
  return data;
}

// Reader of a byte string that never passes its end.
class Bytes {
 public:
  explicit Bytes(std::string_view bytes) : bytes_(bytes) {}

  uint64_t left() const { return bytes_.size() - at_; }
  template <typename T>
  bool take(std::vector<T>& to, uint64_t count) {
    if (count > left() / sizeof(T)) return false;
    to.resize(count);
    if (count > 0) std::memcpy(to.data(), bytes_.data() + at_, count * sizeof(T));
    at_ += count * sizeof(T);
    return true;
  }
  template <typename T>
  bool take(T& to) {
    if (sizeof(T) > left()) return false;
    std::memcpy(&to, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return true;
  }

 private:
  std::string_view bytes_;
  size_t at_ = 0;
};

constexpr size_t kNameBytes = 40;

bool take_bone(Bytes& bytes, SkinData::Bone& bone) {
  std::array<char, kNameBytes> name;
  std::array<float, 7> pose;
  uint32_t count = 0;
  if (!bytes.take(name) || !bytes.take(pose) || !bytes.take(count)) return false;
  bone.body.assign(name.data(), strnlen(name.data(), kNameBytes - 1));
  bone.position = glm::vec3(pose[0], pose[1], pose[2]);
  bone.rotation = glm::dquat(static_cast<double>(pose[3]), static_cast<double>(pose[4]),
                             static_cast<double>(pose[5]), static_cast<double>(pose[6]));
  return bytes.take(bone.vertices, count) && bytes.take(bone.weights, count);
}

// Numbers of an attribute. Empty: it holds something else.
std::optional<std::vector<double>> numbers_of(const MjcfElement& element, std::string_view attribute) {
  const std::string* const text = element.find(attribute);
  if (!text) return std::vector<double>();
  if (!is_mjcf_numbers(*text, kMaxSkinNumbers)) return std::nullopt;
  return mjcf_numbers(*text, kMaxSkinNumbers);
}

// Vectors of an attribute, or the reason why it has none.
template <typename Vector>
Result<std::vector<Vector>> vectors_of(const MjcfElement& element, const char* attribute) {
  constexpr size_t kLength = static_cast<size_t>(Vector::length());
  const auto numbers = numbers_of(element, attribute);
  if (!numbers || numbers->size() % kLength != 0)
    return Error{std::string(attribute) + " is not " + std::to_string(kLength) + " numbers for each vertex"};
  std::vector<Vector> made(numbers->size() / kLength);
  for (size_t i = 0; i < numbers->size(); ++i)
    made[i / kLength][static_cast<int>(i % kLength)] = static_cast<float>((*numbers)[i]);
  return made;
}

// Indices from 0; others become one that is out of bounds.
uint32_t index_of(double number) {
  constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
  return number >= 0 && number < static_cast<double>(kNone) ? static_cast<uint32_t>(number) : kNone;
}

Result<SkinData::Bone> inline_bone(const MjcfElement& element) {
  SkinData::Bone bone;
  bone.body = element.text("body");
  const auto position = numbers_of(element, "bindpos"), rotation = numbers_of(element, "bindquat"),
             vertices = numbers_of(element, "vertid"), weights = numbers_of(element, "vertweight");
  if (!position || position->size() != 3 || !rotation || rotation->size() != 4 || !vertices || !weights)
    return Error{"the bone " + quote(bone.body) +
                 " has not three numbers as bindpos, four as bindquat, and "
                 "numbers as vertid and vertweight"};
  const auto& p = *position;
  const auto& q = *rotation;
  bone.position = {p[0], p[1], p[2]};
  bone.rotation = glm::dquat(q[0], q[1], q[2], q[3]);
  for (const double vertex : *vertices) bone.vertices.push_back(index_of(vertex));
  for (const double weight : *weights) bone.weights.push_back(static_cast<float>(weight));
  return bone;
}

// Adds a bone, or replaces the weakest.
void add_influence(uint16_t joint, float weight, size_t& count, Influences& to) {
  size_t slot = count;
  if (count == to.joints.size()) {
    slot = static_cast<size_t>(std::min_element(to.weights.begin(), to.weights.end()) - to.weights.begin());
    if (to.weights[slot] >= weight) return;
  } else {
    ++count;
  }
  to.joints[slot] = joint;
  to.weights[slot] = weight;
}

}  // namespace

Result<SkinData> parse_skn(std::string_view text) {
  const Error wrong_size{"the SKN file has counts that differ from its contents; export it again"};
  Bytes bytes(text);
  std::array<uint32_t, 4> counts;
  if (!bytes.take(counts)) return wrong_size;
  const auto [vertices, uvs, faces, bones] = counts;
  SkinData data;
  if (!bytes.take(data.vertices, vertices) || !bytes.take(data.uvs, uvs) || !bytes.take(data.faces, faces))
    return wrong_size;
  constexpr size_t kMinBoneBytes = kNameBytes + 8 * 4;
  if (bones > bytes.left() / kMinBoneBytes) return wrong_size;
  data.bones.resize(bones);
  for (SkinData::Bone& bone : data.bones)
    if (!take_bone(bytes, bone)) return wrong_size;
  if (bytes.left() != 0) return wrong_size;
  return checked(std::move(data));
}

Result<SkinData> parse_inline_skin(const MjcfElement& element) {
  SkinData data;
  Result<std::vector<glm::vec3>> vertices = vectors_of<glm::vec3>(element, "vertex");
  if (!vertices) return vertices.error();
  data.vertices = std::move(*vertices);
  Result<std::vector<glm::vec2>> uvs = vectors_of<glm::vec2>(element, "texcoord");
  if (!uvs) return uvs.error();
  data.uvs = std::move(*uvs);
  const auto corners = numbers_of(element, "face");
  if (!corners || corners->size() % 3 != 0) return Error{"face is not three numbers for each triangle"};
  for (size_t i = 0; i + 3 <= corners->size(); i += 3)
    data.faces.push_back({index_of((*corners)[i]), index_of((*corners)[i + 1]), index_of((*corners)[i + 2])});
  for (const MjcfElement& child : element.children) {
    if (child.kind != "bone") continue;
    Result<SkinData::Bone> bone = inline_bone(child);
    if (!bone) return bone.error();
    data.bones.push_back(std::move(*bone));
  }
  return checked(std::move(data));
}

Result<BoundSkin> bind_skin(const SkinData& data, double distance) {
  BoundSkin made;
  Surface& surface = made.surface;
  surface.positions = data.vertices;
  surface.uvs = data.uvs;
  for (const auto& face : data.faces) surface.indices.insert(surface.indices.end(), face.begin(), face.end());
  surface.influences.resize(data.vertices.size());
  std::vector<size_t> counts(data.vertices.size(), 0);
  for (size_t b = 0; b < data.bones.size(); ++b) {
    const SkinData::Bone& bone = data.bones[b];
    for (size_t i = 0; i < bone.vertices.size(); ++i) {
      const uint32_t vertex = bone.vertices[i];
      if (bone.weights[i] < 0 || counts[vertex] == surface.influences[vertex].joints.size())
        made.has_all_bones = false;
      if (bone.weights[i] <= 0) continue;
      add_influence(static_cast<uint16_t>(b), bone.weights[i], counts[vertex], surface.influences[vertex]);
    }
  }
  for (size_t v = 0; v < counts.size(); ++v) {
    double sum = 0;
    for (const float weight : surface.influences[v].weights) sum += static_cast<double>(weight);
    if (!(sum > kMinWeight) || !std::isfinite(sum))
      return Error{"its vertex " + std::to_string(v) + " has no bone with a positive weight"};
    for (float& weight : surface.influences[v].weights)
      weight = static_cast<float>(static_cast<double>(weight) / sum);
    made.is_rigid = made.is_rigid && counts[v] == 1;
  }
  inflate(distance, surface);
  return made;
}

void inflate(double distance, Surface& surface) {
  std::vector<glm::dvec3> sums(surface.positions.size(), glm::dvec3(0));
  for (size_t i = 0; i + 3 <= surface.indices.size(); i += 3) {
    const uint32_t* face = &surface.indices[i];
    const glm::dvec3 a(surface.positions[face[0]]), b(surface.positions[face[1]]),
        c(surface.positions[face[2]]);
    const glm::dvec3 area = glm::cross(b - a, c - a);
    for (size_t k = 0; k < 3; ++k) sums[face[k]] += area;
  }
  surface.normals.clear();
  for (size_t v = 0; v < sums.size(); ++v) {
    const double length = glm::length(sums[v]);
    const glm::dvec3 normal = length > 0 ? sums[v] / length : glm::dvec3(0, 0, 1);
    surface.normals.emplace_back(normal);
    if (length > 0) surface.positions[v] = glm::vec3(glm::dvec3(surface.positions[v]) + distance * normal);
  }
}

}  // namespace fire3dv::convert
