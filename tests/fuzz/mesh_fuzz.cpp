// Fuzz target of the readers of mesh files that are this tree's own: STL, PLY, the checked text of OBJ, the
// repaired text of DAE, and the triangulation of polygons. Any bytes are refused, or give a whole mesh.
#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "convert/mesh/geometry/triangulate.h"
#include "convert/mesh/mtl.h"
#include "convert/mesh/ply.h"
#include "convert/mesh/stl.h"
#include "convert/mesh/text/dae_repair.h"
#include "convert/mesh/text/obj_text.h"
#include "tests/fuzz/target.h"
#include "tests/unit/convert/mesh/mesh_file_bytes.h"

namespace fire3dv::fuzz {
namespace {

// The first byte of an input selects the reader.
enum Reader : uint8_t { kStl, kPly, kObj, kDae, kMtl, kPolygon, kReaders };

bool is_one_line(const std::string& text) {
  for (const char c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return false;
  return !text.empty();
}

void check(const Result<convert::ImportedMesh>& mesh) {
  if (!mesh) {
    FIRE3DV_ASSERT(is_one_line(mesh.error().message));
    return;
  }
  FIRE3DV_ASSERT(convert::check_imported(*mesh).ok());
  FIRE3DV_ASSERT(!mesh->surfaces.empty());
  for (const std::string& warning : mesh->warnings) FIRE3DV_ASSERT(is_one_line(warning));
}

// The checked text needs no further change.
void check_obj(std::string_view text) {
  const Result<convert::ObjText> once = convert::checked_obj(text);
  if (!once) {
    FIRE3DV_ASSERT(is_one_line(once.error().message));
    return;
  }
  for (const std::string& warning : once->warnings) FIRE3DV_ASSERT(is_one_line(warning));
  const Result<convert::ObjText> twice = convert::checked_obj("#\n" + once->text);
  FIRE3DV_ASSERT(twice.ok() && twice->warnings.empty());
}

void check_polygon(std::string_view bytes) {
  std::vector<glm::dvec3> corners;
  for (size_t i = 0; i + 2 < bytes.size(); i += 3)
    corners.emplace_back(bytes[i], bytes[i + 1], bytes[i + 2] % 3);
  convert::PolygonTriangulator triangulator;
  const auto& triangles = triangulator.triangulate(corners);
  FIRE3DV_ASSERT(triangles.size() + 2 <= std::max<size_t>(corners.size(), 2));
  for (const auto& triangle : triangles)
    for (const uint32_t corner : triangle) FIRE3DV_ASSERT(corner < corners.size());
}

}  // namespace

std::vector<Input> seeds() {
  std::string strips =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
      "0 0 0 1\n1 0 0 2\n1 1 0 3\n0 1 0 4\n10 0 1 3 2 -1 0 1 2 2 2\n";
  std::string faces =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n"
      "property uchar red\nproperty uchar alpha\nend_header\n0 0 0\n2 0 0\n1 1 0\n0 3 0\n"
      "4 0 1 2 3 8 0 0 1 0 1 1 0 1 255 7\n";
  const std::pair<Reader, std::string> texts[] = {
      {kStl, test::kAsciiStl},
      {kStl, test::binary_stl()},
      {kStl, "COLOR=\x01\x02\x03\x04" + test::binary_stl().substr(10)},
      {kPly, test::kPly},
      {kPly, strips},
      {kPly, faces},
      {kObj, test::kObj},
      {kObj, "v .5 -.5 +1e-3 1 1 1\nv 1d0 0 0 2\nv 0 1\nvt .5\nf 1/1 2/1 \\\n -1/9//\nf 1//1 2//1 3//1\n"},
      {kDae, test::kDae},
      {kMtl, test::kMtl},
      {kPolygon, std::string("\0\0\0\3\0\0\3\3\0\0\3\0\0\0\0\1\1\0\1\2\0\2\2\0\2\1\0\1\1\0", 30)}};
  std::vector<Input> inputs;
  for (const auto& [reader, text] : texts) {
    inputs.emplace_back(1, reader);
    inputs.back().insert(inputs.back().end(), text.begin(), text.end());
  }
  return inputs;
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv;
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  const bool keeps_nodes = data[0] / fuzz::kReaders % 2 == 0;
  const convert::Nodes nodes = keeps_nodes ? convert::Nodes::keep : convert::Nodes::merge;
  switch (data[0] % fuzz::kReaders) {
    case fuzz::kStl:
      fuzz::check(convert::import_stl(bytes, nodes));
      break;
    case fuzz::kPly:
      fuzz::check(convert::import_ply(bytes, nodes));
      break;
    case fuzz::kObj:
      fuzz::check_obj(bytes);
      break;
    case fuzz::kDae:
      for (const std::string& warning : convert::repair_dae(bytes).warnings)
        FIRE3DV_ASSERT(fuzz::is_one_line(warning));
      break;
    case fuzz::kMtl: {
      convert::MtlMaterials materials;
      materials.add(bytes);
      for (const std::string& warning : materials.warnings()) FIRE3DV_ASSERT(fuzz::is_one_line(warning));
      break;
    }
    default:
      fuzz::check_polygon(bytes);
  }
  return 0;
}
