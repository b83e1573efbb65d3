#include "protocol/record/foxglove_entities.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <vector>

#include "point_cloud_generated.h"
#include "protocol/record/foxglove.h"
#include "protocol/record/foxglove_encoding.h"
#include "scene_update_generated.h"

namespace fire3dv::record {
namespace {

using flatbuffers::Offset;
using wire::Affine3x4d;
using wire::Marker;
using wire::MarkerKind;
using Vector = std::array<double, 3>;
using Quaternion = std::array<double, 4>;

// Arrows and axes with widths in pixels have no equivalent: share of their length.
constexpr double kShaftOfLength = 0.05;

Vector point_at(const Affine3x4d& a, const std::array<float, 3>& p) {
  Vector result;
  for (size_t row = 0; row < 3; ++row)
    result[row] = a.m[row * 4] * double{p[0]} + a.m[row * 4 + 1] * double{p[1]} +
                  a.m[row * 4 + 2] * double{p[2]} + a.m[row * 4 + 3];
  return result;
}

double determinant(const Affine3x4d& a) {
  const auto& m = a.m;
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
         m[2] * (m[4] * m[9] - m[5] * m[8]);
}

wire::Affine3x4 rotation_of(const std::array<float, 4>& q) {
  const double length =
      std::hypot(std::hypot(double{q[0]}, double{q[1]}), std::hypot(double{q[2]}, double{q[3]}));
  const double x = q[0] / length, y = q[1] / length, z = q[2] / length, w = q[3] / length;
  wire::Affine3x4 result;
  const auto at = [&](size_t row, size_t column, double value) {
    result.m[row * 4 + column] = static_cast<float>(value);
  };
  at(0, 0, 1 - 2 * (y * y + z * z)), at(0, 1, 2 * (x * y - z * w)), at(0, 2, 2 * (x * z + y * w));
  at(1, 0, 2 * (x * y + z * w)), at(1, 1, 1 - 2 * (x * x + z * z)), at(1, 2, 2 * (y * z - x * w));
  at(2, 0, 2 * (x * z - y * w)), at(2, 1, 2 * (y * z + x * w)), at(2, 2, 1 - 2 * (x * x + y * y));
  return result;
}

// An element's axes in the entity's frame: a rotation, and the length of each axis. Shear is left out.
struct Axes {
  Quaternion rotation_xyzw;
  Vector lengths;
  Affine3x4d linear;
};
Axes axes_of(const Affine3x4d& frame_from_marker, const std::array<float, 4>& q) {
  Axes result;
  result.linear = product(frame_from_marker, rotation_of(q));
  Affine3x4d unit = result.linear;
  for (size_t axis = 0; axis < 3; ++axis) {
    double square = 0;
    for (size_t row = 0; row < 3; ++row) square += unit.m[row * 4 + axis] * unit.m[row * 4 + axis];
    result.lengths[axis] = std::sqrt(square);
    if (square > 0)
      for (size_t row = 0; row < 3; ++row) unit.m[row * 4 + axis] /= result.lengths[axis];
  }
  // A mirrored solid equals the solid turned, since each is symmetric.
  if (determinant(unit) < 0)
    for (size_t row = 0; row < 3; ++row) unit.m[row * 4] = -unit.m[row * 4];
  result.rotation_xyzw = rigid_part(unit).rotation_xyzw;
  return result;
}

// Shortest rotation from +X to a direction of length 1.
Quaternion rotation_from_x(const Vector& to) {
  const double w = 1 + to[0];
  if (w < 1e-9) return {0, 0, 1, 0};
  const double length = std::sqrt(to[1] * to[1] + to[2] * to[2] + w * w);
  return {0, -to[2] / length, to[1] / length, w / length};
}

class EntityEncoder {
 public:
  EntityEncoder(const Marker& marker, const Affine3x4d& frame_from_marker)
      : builder_(builder_that_writes_all(std::min<uint64_t>(max_bytes(marker), 1 << 16))),
        marker_(marker),
        frame_from_marker_(frame_from_marker),
        is_in_pixels_(marker.width_unit == wire::MarkerUnit::pixels),
        width_(is_in_pixels_ ? double{marker.width} : double{marker.width} * scale_of(frame_from_marker)) {}

  wire::Bytes encode(const std::string& id, const std::string& frame_id, uint64_t time_ns) {
    add_primitives();
    const auto arrows = list_of(arrows_);
    const auto cubes = list_of(cubes_);
    const auto spheres = list_of(spheres_);
    const auto cylinders = list_of(cylinders_);
    const auto lines = list_of(lines_);
    const auto triangles = list_of(triangles_);
    const auto texts = list_of(texts_);
    const auto frame = builder_.CreateString(frame_id);
    const auto name = builder_.CreateString(id);
    const foxglove::Time time = time_of(time_ns);
    const foxglove::Duration for_ever(0, 0);
    foxglove::SceneEntityBuilder entity(builder_);
    entity.add_timestamp(&time);
    entity.add_frame_id(frame);
    entity.add_id(name);
    entity.add_lifetime(&for_ever);
    entity.add_frame_locked(true);
    if (!arrows.IsNull()) entity.add_arrows(arrows);
    if (!cubes.IsNull()) entity.add_cubes(cubes);
    if (!spheres.IsNull()) entity.add_spheres(spheres);
    if (!cylinders.IsNull()) entity.add_cylinders(cylinders);
    if (!lines.IsNull()) entity.add_lines(lines);
    if (!triangles.IsNull()) entity.add_triangles(triangles);
    if (!texts.IsNull()) entity.add_texts(texts);
    const auto finished = entity.Finish();
    builder_.Finish(foxglove::CreateSceneUpdate(builder_, 0, builder_.CreateVector(&finished, 1)));
    const auto bytes = bytes_of(builder_);
    return {bytes.begin(), bytes.end()};
  }

 private:
  template <typename Primitive>
  Offset<flatbuffers::Vector<Offset<Primitive>>> list_of(const std::vector<Offset<Primitive>>& primitives) {
    return primitives.empty() ? 0 : builder_.CreateVector(primitives);
  }

  Offset<foxglove::Color> color(uint32_t rgba) {
    const auto channel = [&](int shift) { return (rgba >> shift & 0xff) / 255.0; };
    return foxglove::CreateColor(builder_, channel(0), channel(8), channel(16), channel(24));
  }
  Offset<foxglove::Color> color_of(size_t index) {
    if (marker_.colors.size() > 1) return color(marker_.colors[index]);
    if (one_color_.IsNull()) one_color_ = color(marker_.colors.empty() ? 0xffffffff : marker_.colors[0]);
    return one_color_;
  }
  Offset<foxglove::Vector3> vector(const Vector& v) {
    return foxglove::CreateVector3(builder_, v[0], v[1], v[2]);
  }
  Offset<foxglove::Pose> pose(const Vector& position, const Quaternion& q) {
    const auto orientation = foxglove::CreateQuaternion(builder_, q[0], q[1], q[2], q[3]);
    const auto origin = vector(position);
    return foxglove::CreatePose(builder_, origin, orientation);
  }
  Vector position_of(size_t index) const { return point_at(frame_from_marker_, marker_.positions[index]); }
  template <typename Element>
  static const Element& of(const std::vector<Element>& elements, size_t index) {
    return elements[elements.size() > 1 ? index : 0];
  }
  Axes axes_at(size_t index) const {
    return axes_of(frame_from_marker_, marker_.rotations.empty() ? std::array<float, 4>{0, 0, 0, 1}
                                                                 : of(marker_.rotations, index));
  }

  // Points and colours of lines and triangles.
  struct Vertices {
    Offset<flatbuffers::Vector<Offset<foxglove::Point3>>> points;
    Offset<flatbuffers::Vector<Offset<foxglove::Color>>> colors;
    Offset<flatbuffers::Vector<uint32_t>> indices;
    Offset<foxglove::Color> color;
    Offset<foxglove::Pose> pose;
  };
  Vertices vertices() {
    std::vector<Offset<foxglove::Point3>> points;
    std::vector<Offset<foxglove::Color>> colors;
    for (size_t i = 0; i < marker_.positions.size(); ++i) {
      const Vector p = position_of(i);
      points.push_back(foxglove::CreatePoint3(builder_, p[0], p[1], p[2]));
      if (marker_.colors.size() > 1) colors.push_back(color_of(i));
    }
    Vertices result;
    result.points = builder_.CreateVector(points);
    result.colors = builder_.CreateVector(colors);
    result.indices = builder_.CreateVector(std::vector<uint32_t>());
    result.color = color_of(0);
    result.pose = pose({0, 0, 0}, {0, 0, 0, 1});
    return result;
  }

  void add_arrow(const Vector& tail, const Vector& tip, double diameter,
                 Offset<foxglove::Color> arrow_color) {
    Vector along;
    double square = 0;
    for (size_t i = 0; i < 3; ++i) {
      along[i] = tip[i] - tail[i];
      square += along[i] * along[i];
    }
    const double length = std::sqrt(square);
    if (!(length > 0)) return;
    for (double& value : along) value /= length;
    // The proportions that renderers of ours draw.
    const double head = std::min(2.5 * diameter, 0.5 * length);
    const auto arrow_pose = pose(tail, rotation_from_x(along));
    arrows_.push_back(foxglove::CreateArrowPrimitive(builder_, arrow_pose, length - head, diameter, head,
                                                     2 * diameter, arrow_color));
  }
  double shaft_of(double length) const { return is_in_pixels_ ? kShaftOfLength * length : width_; }
  static double distance(const Vector& a, const Vector& b) {
    return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                     (a[2] - b[2]) * (a[2] - b[2]));
  }

  void add_axes(size_t index) {
    const Axes axes = axes_at(index);
    const Vector origin = position_of(index);
    const auto& size = of(marker_.sizes, index);
    for (size_t axis = 0; axis < 3; ++axis) {
      Vector tip = origin;
      for (size_t row = 0; row < 3; ++row) tip[row] += axes.linear.m[row * 4 + axis] * double{size[axis]};
      add_arrow(origin, tip, shaft_of(distance(origin, tip)), color(0xff000000u | 0xffu << (8 * axis)));
    }
  }

  void add_sphere(const Vector& position, const Quaternion& rotation, const Vector& size, size_t index) {
    const auto where = pose(position, rotation);
    const auto extent = vector(size);
    const auto tint = color_of(index);
    spheres_.push_back(foxglove::CreateSpherePrimitive(builder_, where, extent, tint));
  }

  void add_solid(size_t index) {
    const Axes axes = axes_at(index);
    const auto& given = of(marker_.sizes, index);
    const Vector position = position_of(index);
    Vector size;
    for (size_t axis = 0; axis < 3; ++axis) size[axis] = axes.lengths[axis] * double{given[axis]};
    if (marker_.kind == MarkerKind::spheres) return add_sphere(position, axes.rotation_xyzw, size, index);
    const auto where = pose(position, axes.rotation_xyzw);
    const auto extent = vector(size);
    const auto tint = color_of(index);
    if (marker_.kind == MarkerKind::boxes) {
      cubes_.push_back(foxglove::CreateCubePrimitive(builder_, where, extent, tint));
      return;
    }
    cylinders_.push_back(foxglove::CreateCylinderPrimitive(builder_, where, extent, 1, 1, tint));
    if (marker_.kind != MarkerKind::capsules) return;
    for (const double end : {-0.5, 0.5}) {
      Vector centre = position;
      for (size_t row = 0; row < 3; ++row) centre[row] += axes.linear.m[row * 4 + 2] * end * double{given[2]};
      add_sphere(centre, axes.rotation_xyzw, {size[0], size[1], 0.5 * (size[0] + size[1])}, index);
    }
  }

  void add_text(size_t index) {
    const auto where = pose(position_of(index), {0, 0, 0, 1});
    const auto tint = color_of(index);
    const auto text = builder_.CreateString(marker_.texts[index]);
    texts_.push_back(foxglove::CreateTextPrimitive(builder_, where, true, width_, is_in_pixels_, tint, text));
  }

  void add_lines(foxglove::LineType type) {
    const Vertices v = vertices();
    lines_.push_back(foxglove::CreateLinePrimitive(builder_, type, v.pose, width_, is_in_pixels_, v.points,
                                                   v.color, v.colors, v.indices));
  }

  void add_primitives() {
    const size_t count = marker_.positions.size();
    switch (marker_.kind) {
      case MarkerKind::points:
      case MarkerKind::images:
        break;  // a point cloud; not converted
      case MarkerKind::lines:
        return add_lines(foxglove::LineType::LINE_LIST);
      case MarkerKind::line_strip:
        return add_lines(foxglove::LineType::LINE_STRIP);
      case MarkerKind::arrows:
        for (size_t i = 0; i + 1 < count; i += 2) {
          const Vector tail = position_of(i), tip = position_of(i + 1);
          add_arrow(tail, tip, shaft_of(distance(tail, tip)), color_of(i));
        }
        break;
      case MarkerKind::axes:
        for (size_t i = 0; i < count; ++i) add_axes(i);
        break;
      case MarkerKind::boxes:
      case MarkerKind::spheres:
      case MarkerKind::cylinders:
      case MarkerKind::capsules:
        for (size_t i = 0; i < count; ++i) add_solid(i);
        break;
      case MarkerKind::triangles: {
        const Vertices v = vertices();
        triangles_.push_back(
            foxglove::CreateTriangleListPrimitive(builder_, v.pose, v.points, v.color, v.colors, v.indices));
        break;
      }
      case MarkerKind::texts:
        for (size_t i = 0; i < count; ++i) add_text(i);
        break;
    }
  }

  flatbuffers::FlatBufferBuilder builder_;
  const Marker& marker_;
  const Affine3x4d& frame_from_marker_;
  bool is_in_pixels_;
  double width_;
  Offset<foxglove::Color> one_color_;
  std::vector<Offset<foxglove::ArrowPrimitive>> arrows_;
  std::vector<Offset<foxglove::CubePrimitive>> cubes_;
  std::vector<Offset<foxglove::SpherePrimitive>> spheres_;
  std::vector<Offset<foxglove::CylinderPrimitive>> cylinders_;
  std::vector<Offset<foxglove::LinePrimitive>> lines_;
  std::vector<Offset<foxglove::TriangleListPrimitive>> triangles_;
  std::vector<Offset<foxglove::TextPrimitive>> texts_;
};

}  // namespace

double scale_of(const Affine3x4d& a) {
  return std::cbrt(std::abs(determinant(a)));
}

uint64_t max_bytes(const Marker& marker) {
  constexpr uint64_t kHead = 4096;
  // Of one position; by kind.
  constexpr uint64_t kOf[] = {16, 112, 112, 160, 960, 288, 288, 320, 896, 112, 320, 0};
  static_assert(std::size(kOf) == wire::kMarkerKindCount);
  uint64_t bytes = kHead + kOf[static_cast<size_t>(marker.kind)] * marker.positions.size();
  for (const std::string& text : marker.texts) bytes += text.size() + 8;
  return bytes;
}

wire::Bytes encode_entity(const Marker& marker, const std::string& id, const std::string& frame_id,
                          const Affine3x4d& frame_from_marker, uint64_t time_ns) {
  return EntityEncoder(marker, frame_from_marker).encode(id, frame_id, time_ns);
}

wire::Bytes encode_cloud(const Marker& marker, const std::string& frame_id,
                         const Affine3x4d& frame_from_marker, uint64_t time_ns) {
  constexpr uint32_t kStride = 16;
  auto builder = builder_that_writes_all(1024);
  uint8_t* data = nullptr;
  const auto bytes = builder.CreateUninitializedVector(marker.positions.size() * kStride, &data);
  Affine3x4d linear = frame_from_marker;
  linear.m[3] = linear.m[7] = linear.m[11] = 0;
  for (size_t i = 0; i < marker.positions.size(); ++i, data += kStride) {
    const Vector at = point_at(linear, marker.positions[i]);
    const std::array<float, 3> point{static_cast<float>(at[0]), static_cast<float>(at[1]),
                                     static_cast<float>(at[2])};
    const uint32_t rgba =
        marker.colors.empty() ? 0xffffffff : marker.colors[marker.colors.size() > 1 ? i : 0];
    std::memcpy(data, point.data(), sizeof point);
    std::memcpy(data + sizeof point, &rgba, sizeof rgba);
  }
  std::vector<Offset<foxglove::PackedElementField>> fields;
  uint32_t offset = 0;
  const auto add = [&](const char* name, foxglove::NumericType type, uint32_t size) {
    const auto text = builder.CreateString(name);
    fields.push_back(foxglove::CreatePackedElementField(builder, text, offset, type));
    offset += size;
  };
  for (const char* name : {"x", "y", "z"}) add(name, foxglove::NumericType::FLOAT32, 4);
  for (const char* name : {"red", "green", "blue", "alpha"}) add(name, foxglove::NumericType::UINT8, 1);
  const auto field_list = builder.CreateVector(fields);
  const auto& m = frame_from_marker.m;
  const auto position = foxglove::CreateVector3(builder, m[3], m[7], m[11]);
  const auto orientation = foxglove::CreateQuaternion(builder, 0, 0, 0, 1);
  const auto pose = foxglove::CreatePose(builder, position, orientation);
  const auto frame = builder.CreateString(frame_id);
  const foxglove::Time time = time_of(time_ns);
  builder.Finish(foxglove::CreatePointCloud(builder, &time, frame, pose, kStride, field_list, bytes));
  const auto message = bytes_of(builder);
  return {message.begin(), message.end()};
}

}  // namespace fire3dv::record
