#include "renderer/scene/gltf/foreign_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <string_view>
#include <system_error>

#include "base/files.h"
#include "base/text.h"

namespace fire3dv::scene {
namespace {

constexpr size_t kHead = 4096;
constexpr const char* kExport = "export it as glTF (.glb), for example with Blender";
constexpr const char* kExportFromBlender = "export it from Blender: File > Export > glTF 2.0 (.glb)";
constexpr const char* kMesh = "mesh it in a CAD program such as FreeCAD, and export glTF, OBJ or STL";
constexpr const char* kConvert = "convert it first: fire3dv-convert FILE -o scene.glb";
constexpr const char* kByName =
    "fire3dv-convert converts AMBF, URDF, MJCF and SDF descriptions, recognised by .yaml, .urdf, .xml, "
    ".xacro "
    "or .sdf";
constexpr const char* kUnpack = "unpack it first";
constexpr const char* kNameScene = "name a scene in glTF (.glb or .gltf)";
constexpr const char* kRelabel =
    "states of other programs are drawn by fire3dv relabel FILE SCENE --format FORMAT --out DIR";
constexpr const char* kPoints = "point clouds are not drawn: make a mesh of it, for example with MeshLab";

struct Signature {
  std::string_view start;
  const char* format;
  const char* remedy;
};

using namespace std::string_view_literals;  // some hold zero bytes

constexpr Signature kSignatures[] = {
    {"#usda ", "a USD scene (text)", kExport},
    {"PXR-USDC", "a USD scene (binary)", kExport},
    {"Kaydara FBX Binary", "an FBX scene", kExport},
    {"; FBX ", "an FBX scene (text)", kExport},
    {"BLENDER", "a Blender project", kExportFromBlender},
    {"ply\n", "a PLY mesh", "give it the ending .ply, so that it is converted"},
    {"ply\r\n", "a PLY mesh", "give it the ending .ply, so that it is converted"},
    {"OFF\n", "an OFF mesh", kExport},
    {"OFF\r\n", "an OFF mesh", kExport},
    {"ISO-10303-21;", "a STEP model", kMesh},
    {"3D Geometry File Format", "a Rhino model", kExport},
    {"#VRML", "a VRML scene", kExport},
    {"Ogawa", "an Alembic scene", kExport},
    {"# .PCD", "a point cloud (PCD)", kPoints},
    {"ASTM-E57", "a point cloud (E57)", kPoints},
    {"LASF", "a point cloud (LAS)", kPoints},
    {"7z\xBC\xAF\x27\x1C", "a 7-Zip archive", kUnpack},
    {"Rar!", "a RAR archive", kUnpack},
    {"BZh", "a bzip2 archive", kUnpack},
    {"\xFD"
     "7zXZ\0"sv,
     "an xz archive", kUnpack},
    {"\x28\xB5\x2F\xFD", "a Zstandard archive", kUnpack},
    {"\x1F\x8B", "a gzip archive", kUnpack},
    {"\x89MCAP0\r\n", "a recording (MCAP)", "replay it: fire3dv SCENE.glb --replay FILE"},
    {"#ROSBAG", "a ROS 1 bag", "convert it to a bag of ROS 2, and draw that by fire3dv relabel"},
    {"SQLite format 3", "a bag of ROS 2 or another SQLite database", kRelabel},
    {"\x89HDF\r\n\x1a\n", "an HDF5 file", kRelabel},
    {"\x89PNG", "a PNG image", kNameScene},
    {"\xFF\xD8\xFF", "a JPEG image", kNameScene},
    {"GIF8", "a GIF image", kNameScene},
    {"II*\0"sv, "a TIFF image", kNameScene},
    {"MM\0*"sv, "a TIFF image", kNameScene},
    {"DDS ", "a DDS image", kNameScene},
    {"\xABKTX", "a KTX image", kNameScene},
    {"\x76\x2F\x31\x01", "an OpenEXR image", "name a scene, and this file with --environment"},
    {"#?RADIANCE", "an environment map (Radiance)", "name a scene, and this file with --environment"},
    {"#?RGBE", "an environment map (Radiance)", "name a scene, and this file with --environment"},
    {"%PDF", "a PDF document", kNameScene},
    {"\x7F"
     "ELF",
     "a program", kNameScene},
    {"version https://git-lfs", "a pointer of Git LFS", "fetch the file itself: git lfs pull"},
};

struct Extension {
  std::string_view extension;
  const char* format;
  const char* remedy;
};

constexpr Extension kExtensions[] = {
    {".obj", "a Wavefront OBJ mesh", kConvert},
    {".stl", "an STL mesh", kConvert},
    {".ply", "a damaged PLY mesh", kExport},
    {".off", "an OFF mesh", kExport},
    {".3ds", "a 3D Studio scene", kExport},
    {".fbx", "an FBX scene", kExport},
    {".usd", "a USD scene", kExport},
    {".usda", "a USD scene", kExport},
    {".usdc", "a USD scene", kExport},
    {".usdz", "a USD scene", kExport},
    {".blend", "a Blender project", kExportFromBlender},
    {".step", "a STEP model", kMesh},
    {".stp", "a STEP model", kMesh},
    {".iges", "an IGES model", kMesh},
    {".igs", "an IGES model", kMesh},
    {".brep", "an Open CASCADE model", kMesh},
    {".sldprt", "a SolidWorks part", kMesh},
    {".sldasm", "a SolidWorks assembly", kMesh},
    {".ipt", "an Inventor part", kMesh},
    {".iam", "an Inventor assembly", kMesh},
    {".f3d", "a Fusion 360 design", kMesh},
    {".dxf", "a DXF drawing", kMesh},
    {".dwg", "a DWG drawing", kMesh},
    {".3dm", "a Rhino model", kExport},
    {".skp", "a SketchUp model", kExport},
    {".max", "a 3ds Max scene", kExport},
    {".ma", "a Maya scene", kExport},
    {".mb", "a Maya scene", kExport},
    {".c4d", "a Cinema 4D scene", kExport},
    {".abc", "an Alembic scene", kExport},
    {".wrl", "a VRML scene", kExport},
    {".x3d", "an X3D scene", kExport},
    {".xyz", "a point cloud", kPoints},
    {".pcd", "a point cloud", kPoints},
    {".mtl", "the materials of an OBJ mesh", "name the .obj file"},
    {".bin", "a buffer of a glTF scene", "name the .gltf file"},
    {".bmp", "a BMP image", kNameScene},
    {".mjb", "a compiled MuJoCo model", "name the MJCF file (.xml) that it was compiled from"},
    {".mjcf", "an MJCF model", kByName},
    {".sdf", "an SDF description", kByName},
};

std::optional<FileFormat> format_by_extension(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  for (const Extension& each : kExtensions)
    if (extension == each.extension) return FileFormat{each.format, each.remedy};
  return std::nullopt;
}

// ZIP is the container of several formats. The name of its first file stands in the first bytes.
FileFormat zip_format(std::string_view head, const std::filesystem::path& file) {
  constexpr size_t kNameAt = 30;
  const std::string_view name = head.substr(std::min(head.size(), kNameAt), 200);
  const std::string extension = lower_extension(file);
  if (extension == ".3mf" || name.starts_with("3D/"))
    return {"a 3MF model", "give it the ending .3mf, so that it is converted"};
  if (extension == ".usdz" || name.find(".usd") < 100) return {"a USD scene (.usdz)", kExport};
  if (extension == ".f3d" || extension == ".skp") return *format_by_extension(file);
  return {"a ZIP archive", kUnpack};
}

// Format and remedy of an XML document by its root element, which stands in the first bytes.
FileFormat xml_format(std::string_view head) {
  const auto has = [&](std::string_view element) { return head.find(element) != std::string_view::npos; };
  if (has("<COLLADA")) return {"a COLLADA scene", "give it the ending .dae, so that it is converted"};
  if (has("<robot")) return {"a URDF description", kConvert};
  if (has("<mujoco")) return {"an MJCF description", kConvert};
  if (has("<sdf")) return {"an SDF description", kConvert};
  if (has("<X3D")) return {"an X3D scene", kExport};
  if (has("<svg")) return {"an SVG image", kNameScene};
  if (has("<html") || has("<HTML") || has("<!doctype html") || has("<!DOCTYPE html"))
    return {"a web page", "download the file itself, on GitHub by the button Download raw file"};
  return {"an XML file", kByName};
}

// Fixed columns: each line has its section and number at its end.
bool is_iges(std::string_view head) {
  const std::string_view number = head.size() > 80 ? head.substr(73, 7) : std::string_view();
  return !number.empty() && head[72] == 'S' && (number == "0000001" || number == "      1");
}

bool is_text(std::string_view head) {
  return std::ranges::all_of(head, [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x20 || (byte >= 0x07 && byte <= 0x0d);
  });
}

// Scene in a folder that the user named, for the remedy.
std::string example_in(const std::filesystem::path& folder) {
  constexpr std::string_view kScenes[] = {".glb", ".gltf", ".urdf", ".xacro", ".sdf", ".world",
                                          ".obj", ".dae",  ".stl",  ".ply",   ".3mf"};
  constexpr int kMaxEntries = 1000;
  std::error_code error;
  std::string best;
  size_t rank = std::size(kScenes);
  std::filesystem::directory_iterator entries(folder, error);
  for (int i = 0; !error && i < kMaxEntries && entries != std::filesystem::directory_iterator(); ++i) {
    const std::string name = entries->path().filename().string();
    const auto known = std::ranges::find(kScenes, lower_extension(name));
    const auto at = static_cast<size_t>(known - std::begin(kScenes));
    if (at < rank || (at == rank && at < std::size(kScenes) && name < best)) {
      best = name;
      rank = at;
    }
    entries.increment(error);
  }
  return best.empty() ? "" : ", such as " + quote(best);
}

}  // namespace

std::optional<FileFormat> foreign_format(std::span<const std::byte> bytes,
                                         const std::filesystem::path& file) {
  std::string_view head(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), kHead));
  if (head.starts_with("glTF")) return std::nullopt;
  if (head.empty()) return FileFormat{"an empty file", "write it again, or name another one"};
  const bool is_compressed = head.starts_with("\x28\xB5\x2F\xFD") || head.starts_with("\x1F\x8B");
  if (is_compressed && lower_extension(file) == ".blend") return format_by_extension(file);
  for (const Signature& each : kSignatures)
    if (head.starts_with(each.start)) return FileFormat{each.format, each.remedy};
  if (head.starts_with("PK\x03\x04")) return zip_format(head, file);
  if (head.starts_with("RIFF") && head.size() > 12 && head.substr(8, 4) == "WEBP")
    return FileFormat{"a WebP image", kNameScene};
  if (head.size() > 262 && head.substr(257, 5) == "ustar") return FileFormat{"a tar archive", kUnpack};
  if (is_iges(head)) return FileFormat{"an IGES model", kMesh};
  if (head.starts_with("\xEF\xBB\xBF")) head.remove_prefix(3);
  const size_t first = head.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && (head[first] == '{' || head[first] == '[')) return std::nullopt;
  if (first != std::string_view::npos && head[first] == '<') return xml_format(head);
  if (std::optional<FileFormat> named = format_by_extension(file)) return named;
  if (head.starts_with("solid "))
    return FileFormat{"an STL mesh (text)", "give it the ending .stl, so that it is converted"};
  return FileFormat{"", kExport};
}

std::optional<std::string> describe_foreign_file(std::span<const std::byte> bytes,
                                                 const std::filesystem::path& file) {
  const std::optional<FileFormat> format = foreign_format(bytes, file);
  if (!format) return std::nullopt;
  if (bytes.empty()) return "the file is empty; " + format->remedy;
  if (!format->name.empty()) return format->name + ", not glTF; " + format->remedy;
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), kHead));
  return std::string(is_text(head) ? "a text file, not glTF; " : "not glTF: neither JSON nor binary; ") +
         format->remedy;
}

bool is_binary_gltf(const std::filesystem::path& file) {
  const auto opened = OpenFile::open(file, UINT64_MAX);
  std::array<std::byte, 4> magic{};
  return opened && opened->size() >= magic.size() && opened->read(0, magic) &&
         std::memcmp(magic.data(), "glTF", magic.size()) == 0;
}

Result<void> check_is_gltf(const std::filesystem::path& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored))
    return Error{file.string() + ": it is a folder; name a scene in it" + example_in(file)};
  const auto opened = OpenFile::open(file, UINT64_MAX);
  if (!opened) return Error{file.string() + ": " + opened.error().message};
  std::array<std::byte, kHead> bytes;
  const std::span<std::byte> head(bytes.data(), std::min<uint64_t>(opened->size(), kHead));
  if (!opened->read(0, head)) return Error{file.string() + ": it cannot be read; check the disk"};
  if (const auto other = describe_foreign_file(head, file)) return Error{file.string() + ": " + *other};
  return {};
}

}  // namespace fire3dv::scene
