#include "renderer/scene/gltf/meshes/draco_header.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace fire3dv::scene {
namespace {

constexpr size_t kDracoHeaderBytes = 11;  // "DRACO", version, encoder type and method, flags
constexpr size_t kFlagsOffset = 9;
constexpr unsigned kMetadataFlag = 0x80;  // in the high byte of the flags
constexpr unsigned kTriangularMesh = 1, kSequential = 0, kEdgebreaker = 1;

// Memory of draco::Mesh, its corner table and the traversal, per face and per attribute with seams.
constexpr uint64_t kFaceBytes = 96, kSeamBytes = 40;
// Little-endian reader. After the end it returns zeros and is not good().
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  bool good() const { return good_; }
  size_t position() const { return position_; }
  size_t left() const { return bytes_.size() - position_; }

  unsigned byte() {
    if (left() == 0) {
      good_ = false;
      return 0;
    }
    return std::to_integer<unsigned>(bytes_[position_++]);
  }

  uint32_t word() {
    uint32_t value = 0;
    for (unsigned i = 0; i < 4; ++i) value |= uint32_t{byte()} << (8 * i);
    return value;
  }

  uint32_t varint() {
    uint32_t value = 0;
    for (unsigned shift = 0; shift < 35; shift += 7) {
      const unsigned next = byte();
      value |= uint32_t{next & 0x7f} << shift;
      if ((next & 0x80) == 0) return value;
    }
    good_ = false;
    return 0;
  }

  void skip(size_t count) {
    if (count > left()) good_ = false;
    position_ += std::min(count, left());
  }

 private:
  std::span<const std::byte> bytes_;
  size_t position_ = 0;
  bool good_ = true;
};

// Nested metadata follow their parent; only their number counts here. Each takes at least three bytes.
void skip_metadata(ByteReader& reader) {
  uint64_t nested = 0;
  for (bool is_nested = false; reader.good(); is_nested = true) {
    if (is_nested) reader.skip(reader.byte());  // name
    const uint32_t entries = reader.varint();
    for (uint32_t i = 0; i < entries && reader.good(); ++i) {
      reader.skip(reader.byte());  // name
      reader.skip(reader.varint());
    }
    nested += reader.varint();
    if (nested == 0) return;
    --nested;
  }
}

void skip_geometry_metadata(ByteReader& reader) {
  const uint32_t attributes = reader.varint();
  for (uint32_t i = 0; i < attributes && reader.good(); ++i) {
    reader.varint();  // attribute id
    skip_metadata(reader);
  }
  skip_metadata(reader);
}

Error cut_short() {
  return Error{"the Draco stream is cut short"};
}

}  // namespace

uint64_t DracoHeader::connectivity_bytes() const {
  return stream.size() + faces * (kFaceBytes + kSeamBytes * seam_attributes);
}

Result<DracoHeader> read_draco_header(std::span<const std::byte> stream) {
  if (stream.size() < kDracoHeaderBytes) return cut_short();
  if (std::memcmp(stream.data(), "DRACO", 5) != 0)
    return Error{"its bytes are no Draco stream: they do not begin with DRACO"};
  ByteReader reader(stream);
  reader.skip(5);
  const unsigned major = reader.byte(), minor = reader.byte(), version = major << 8 | minor;
  const unsigned geometry = reader.byte(), method = reader.byte();
  reader.skip(kDracoHeaderBytes - kFlagsOffset);
  if (version < 0x100 || version > 0x202)
    return Error{"the Draco version " + std::to_string(major) + "." + std::to_string(minor) +
                 " is not supported: 1.0 to 2.2 are"};
  if (geometry != kTriangularMesh) return Error{"the Draco stream holds a point cloud, not a mesh"};
  if (method != kSequential && method != kEdgebreaker)
    return Error{"the Draco stream has the unknown encoding " + std::to_string(method)};

  DracoHeader header;
  header.stream.assign(stream.begin(), stream.begin() + kDracoHeaderBytes);
  std::byte& flags = header.stream[kFlagsOffset + 1];
  if (version >= 0x103 && (std::to_integer<unsigned>(flags) & kMetadataFlag) != 0) {
    flags &= ~std::byte{kMetadataFlag};
    skip_geometry_metadata(reader);
  }
  header.stream.insert(header.stream.end(), stream.begin() + static_cast<ptrdiff_t>(reader.position()),
                       stream.end());

  const auto number = [&](unsigned first_version_of_varints) {
    return version < first_version_of_varints ? reader.word() : reader.varint();
  };
  if (method == kSequential) {
    header.faces = number(0x202);
    header.max_points = number(0x202);
    header.points_are_exact = true;
  } else {
    reader.byte();                       // traversal
    if (version < 0x202) number(0x200);  // new vertices
    number(0x200);                       // vertices, at most three per face
    header.faces = number(0x200);
    header.max_points = 3 * header.faces;
    header.seam_attributes = reader.byte();
  }
  if (!reader.good()) return cut_short();
  if (header.faces == 0 || header.max_points == 0) return Error{"the Draco stream holds no triangles"};
  return header;
}

}  // namespace fire3dv::scene
