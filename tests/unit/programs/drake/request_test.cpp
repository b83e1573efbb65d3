// Tests of Drake's render requests: the fields of the form, the split of the scene, and depth images. Wanted
// values are from Drake's documentation of its client-server protocol, the glTF and the TIFF specification.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "programs/drake/render/depth_image.h"
#include "programs/drake/request/form.h"
#include "programs/drake/request/gltf_scene.h"

namespace fire3dv::drake {
namespace {

constexpr const char* kType = "multipart/form-data; boundary=b";

// Fields of a depth request; the digest is that of sha256sum for the scene "{}".
std::map<std::string, std::string> depth_fields() {
  return {{"center_x", "320.000000"},
          {"center_y", "240.500000"},
          {"far", "10.000000"},
          {"focal_x", "579.411255"},
          {"focal_y", "579.411255"},
          {"fov_x", "1.0"},
          {"fov_y", "0.785398"},
          {"height", "480"},
          {"image_type", "depth"},
          {"max_depth", "5.0"},
          {"min_depth", "0.1"},
          {"near", "0.010000"},
          {"scene", "{}"},
          {"submit", "Render"},
          {"width", "640"},
          {"scene_sha256", "44136fa355b3678a1146ad16f7e8649e94fb4fc21fe77e8310c060f61caaff8a"}};
}

std::string body_of(const std::map<std::string, std::string>& fields) {
  std::string body;
  for (const auto& [name, value] : fields)
    body += "--b\r\nContent-Disposition: form-data; name=\"" + name + "\"\r\n\r\n" + value + "\r\n";
  return body + "--b--\r\n";
}

std::string fault_with(const std::string& name, const std::string& value) {
  auto fields = depth_fields();
  fields[name] = value;
  const std::string body = body_of(fields);
  const auto request = read_form(body, kType);
  return request ? "" : request.error().message;
}

TEST(DrakeForm, ReadsTheFieldsOfDrake) {
  const std::string body = body_of(depth_fields());
  const auto request = read_form(body, kType);
  ASSERT_TRUE(request) << request.error().message;
  EXPECT_EQ(request->type, ImageType::depth);
  EXPECT_EQ(request->width, 640u);
  EXPECT_EQ(request->height, 480u);
  EXPECT_EQ(request->near_m, 0.01);
  EXPECT_EQ(request->far_m, 10);
  EXPECT_EQ(request->focal_x_px, 579.411255);
  EXPECT_EQ(request->center_y_px, 240.5);
  EXPECT_EQ(request->min_depth_m, 0.1);
  EXPECT_EQ(request->max_depth_m, 5);
  EXPECT_EQ(request->scene, "{}");
}

TEST(DrakeForm, RefusesWhatIsNotRequest) {
  const struct {
    const char *name, *value, *fault;
  } cases[] = {{"width", "0", "\"width\" is \"0\""},
               {"width", "-1", "whole number of pixels"},
               {"width", "1e3", "whole number of pixels"},
               {"width", "99999999999999999999", "whole number of pixels"},
               {"height", "8193", "from 1 to 8192"},
               {"near", "nan", "must be a number above 0"},
               {"near", "inf", "must be a number above 0"},
               {"near", "", "must be a number above 0"},
               {"near", "1 ", "must be a number above 0"},
               {"near", "10.0", "\"near\" must be less than \"far\""},
               {"focal_x", "-5", "\"focal_x\""},
               {"fov_x", "x", "\"fov_x\""},
               {"center_x", "640", "must lie in the image"},
               {"min_depth", "5.0", "\"min_depth\" must be less"},
               {"image_type", "colour", "must be color, depth or label"},
               {"scene_sha256", "00", "is not the SHA-256"},
               {"scene", "{ }", "is not the SHA-256"},
               {"path", "/etc/passwd", "a field \"path\", which"}};
  for (const auto& entry : cases)
    EXPECT_NE(fault_with(entry.name, entry.value).find(entry.fault), std::string::npos)
        << entry.name << "=" << entry.value << ": " << fault_with(entry.name, entry.value);
  for (const auto& [name, value] : depth_fields()) {
    if (name == "submit") continue;
    auto fields = depth_fields();
    fields.erase(name);
    const std::string body = body_of(fields);
    const auto request = read_form(body, kType);
    ASSERT_FALSE(request) << name;
    EXPECT_NE(request.error().message.find("lacks the field \"" + name + "\""), std::string::npos);
  }
  const std::string twice =
      body_of({{"width", "1"}}).substr(0, body_of({{"width", "1"}}).size() - 7) + body_of(depth_fields());
  const auto request = read_form(twice, kType);
  ASSERT_FALSE(request);
  EXPECT_NE(request.error().message.find("\"width\" twice"), std::string::npos);
}

// A box with a camera as VTK writes them; `box` and `camera` are translations along x.
std::string scene_at(double box, double camera, const std::string& color = "[0.2, 0.4, 0, 1]") {
  const auto moved = [](double x) { return "[1,0,0,0, 0,1,0,0, 0,0,1,0, " + std::to_string(x) + ",2,3,1]"; };
  return R"({"asset":{"generator":"VTK","version":"2.0"},"scene":0,"scenes":[{"nodes":[2]}],"nodes":[
    {"matrix":)" +
         moved(box) + R"(,"mesh":0,"name":"mesh0"},
    {"camera":0,"matrix":)" +
         moved(camera) + R"(,"name":"Camera Node"},
    {"children":[0,1],"name":"Renderer Node"}],
    "cameras":[{"type":"perspective","perspective":{"yfov":)" +
         std::to_string(1 + camera * 0.01) + R"(,"znear":0.1}}],
    "materials":[{"pbrMetallicRoughness":{"baseColorFactor":)" +
         color + R"(}}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
    "buffers":[{"byteLength":3,"uri":"data:application/octet-stream;base64,AAAA"}]})";
}

TEST(DrakeScene, DigestIgnoresTransforms) {
  const auto first = GltfScene::read(scene_at(1, 2), ImageType::color);
  const auto moved = GltfScene::read(scene_at(5, 7), ImageType::color);
  const auto painted = GltfScene::read(scene_at(1, 2, "[0.2, 0.5, 0, 1]"), ImageType::color);
  ASSERT_TRUE(first && moved && painted);
  EXPECT_EQ(first->content(), moved->content());
  EXPECT_NE(first->content(), painted->content());
  std::string other_data = scene_at(1, 2);
  other_data.replace(other_data.find("base64,AAAA"), 11, "base64,AAAB");
  const auto other = GltfScene::read(other_data, ImageType::color);
  ASSERT_TRUE(other);
  EXPECT_NE(first->content(), other->content());
  // Materials do not matter for depths and labels.
  const auto depth = GltfScene::read(scene_at(1, 2), ImageType::depth);
  const auto label = GltfScene::read(scene_at(1, 2, "[1, 0, 0, 1]"), ImageType::label);
  ASSERT_TRUE(depth && label);
  EXPECT_EQ(depth->content(), label->content());
}

// Drake's Z axis becomes Y; X stays. Node 1 is the camera, below the turned root.
TEST(DrakeScene, TurnsTheWorldUpright) {
  const auto scene = GltfScene::read(scene_at(1, 4), ImageType::color);
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->world_from_camera()[3], glm::dvec4(4, 3, -2, 1));
  EXPECT_EQ(scene->world_from_camera()[2], glm::dvec4(0, 1, 0, 0));
  EXPECT_EQ(scene->parent_from_node()[0][3], glm::dvec4(1, 2, 3, 1));
  EXPECT_EQ(scene->parent_from_node()[2][1], glm::dvec4(0, 0, -1, 0));
}

// Drake sets `matrix` of merged files' nodes beside a rotation that the file had.
TEST(DrakeScene, AMatrixReplacesOtherParts) {
  std::string text = scene_at(1, 4);
  text.insert(text.find("\"mesh\":0"), "\"rotation\":[1,0,0,0],\"scale\":[2,2,2],");
  const auto scene = GltfScene::read(text, ImageType::color);
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->parent_from_node()[0][0], glm::dvec4(1, 0, 0, 0));
}

TEST(DrakeScene, LabelsAreColoursOfMaterials) {
  // 51 and 102 of 255, as Drake writes label 26163.
  const auto scene = GltfScene::read(scene_at(1, 4), ImageType::label);
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->label_of_node()[0], (Rgb8{51, 102, 0}));
  EXPECT_EQ(scene->label_of_node()[1], (Rgb8{255, 255, 255}));
}

std::string scene_fault(std::string text, const std::string& from, const std::string& to,
                        ImageType type = ImageType::label) {
  text.replace(text.find(from), from.size(), to);
  const auto scene = GltfScene::read(text, type);
  return scene ? "" : scene.error().message;
}

TEST(DrakeScene, RefusesBrokenScenes) {
  const std::string text = scene_at(1, 4);
  for (const char* uri : {"file:///etc/passwd", "box.bin", "../box.bin", "http://example.com/box.bin"})
    EXPECT_NE(
        scene_fault(text, "data:application/octet-stream;base64,AAAA", uri).find("buffers[0] names a file"),
        std::string::npos);
  EXPECT_NE(scene_fault(text, "\"camera\":0,", "").find("0 nodes with a camera"), std::string::npos);
  EXPECT_NE(scene_fault(text, "[0,1]", "[0,9]").find("nodes[2].children"), std::string::npos);
  EXPECT_NE(scene_fault(text, "[0,1]", "[0,\"1\"]").find("nodes[2].children"), std::string::npos);
  EXPECT_NE(scene_fault(text, "\"camera\":0,", "\"camera\":0,\"children\":[2],").find("its own ancestor"),
            std::string::npos);
  EXPECT_NE(scene_fault(text, ",2,3,1]", ",2,3]").find("nodes[0] has a transform"), std::string::npos);
  EXPECT_NE(scene_fault(text, ",2,3,1]", ",2,3,1e300]").find("nodes[0] has a transform"), std::string::npos);
  EXPECT_NE(scene_fault(text, "[0.2, 0.4, 0, 1]", "[0.2]").find("materials[0]"), std::string::npos);
  for (const char* broken : {"", "[]", "null", "{", "{}", "{\"nodes\":7}", "{\"nodes\":[1]}", "\xff\xfe"})
    EXPECT_FALSE(GltfScene::read(broken, ImageType::color)) << broken;
  const auto deep = GltfScene::read(std::string(100'000, '['), ImageType::color);
  ASSERT_FALSE(deep);
  EXPECT_NE(deep.error().message.find("nests deeper"), std::string::npos);
}

// With quadratic time these two take minutes.
TEST(DrakeScene, ManyObjectsAreRead) {
  std::string many = "[{}";
  for (int i = 0; i < 600'000; ++i) many += ",{}";
  std::string text = scene_at(1, 4);
  text.insert(1, "\"extras\":" + many + "],");
  const auto scene = GltfScene::read(text, ImageType::color);
  EXPECT_TRUE(scene) << scene.error().message;
  std::string more = many;
  for (int i = 0; i < 3; ++i) more += "," + many.substr(1);
  text.insert(1, "\"more\":" + more + "],");
  const auto too_many = GltfScene::read(text, ImageType::color);
  ASSERT_FALSE(too_many);
  EXPECT_NE(too_many.error().message.find("more than 4000000 values"), std::string::npos);
}

TEST(DrakeScene, NodesShareMeshOfManySurfaces) {
  constexpr size_t kCount = 30'000;
  std::string nodes, surfaces;
  for (size_t i = 0; i < kCount; ++i) {
    nodes += R"({"mesh":0},)";
    surfaces += R"({"attributes":{"POSITION":0},"material":0},)";
  }
  std::string text = scene_at(1, 4);
  text.insert(text.find(R"({"children")"), nodes);
  const std::string first = R"("primitives":[)";
  text.insert(text.find(first) + first.size(), surfaces);
  const auto scene = GltfScene::read(text, ImageType::label);
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->label_of_node()[kCount], (Rgb8{51, 102, 0}));
}

// Data URIs are found without a JSON parser; the result is that of one.
TEST(DrakeScene, DataUrisMatchAParser) {
  const std::string data = "data:application/octet-stream;base64,AAAA";
  const std::string text = scene_at(1, 4);
  const auto glb_of = [](const std::string& from) {
    auto scene = GltfScene::read(from, ImageType::color);
    if (!scene) return "error: " + scene.error().message;
    const std::vector<std::byte> glb = scene->take_glb();
    return std::string(reinterpret_cast<const char*>(glb.data()) + 20, glb.size() - 20);
  };
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    return changed.replace(changed.find(from), from.size(), to);
  };
  EXPECT_NE(glb_of(text).find("\"uri\":\"" + data + "\""), std::string::npos);
  // An escaped solidus, and an escaped quotation mark before a text that looks like the begin of a URI.
  EXPECT_EQ(glb_of(with(data, "data:application\\/octet-stream;base64,AAAA")), glb_of(text));
  EXPECT_EQ(glb_of(with("\"generator\":\"VTK\"", R"("generator":"\\\"data:x")")), glb_of(text));
  EXPECT_EQ(glb_of(with("\"generator\":\"VTK\"", R"("generator":"data:x","data:":"data:y")")), glb_of(text));
  // Strings that look like the parser's own placeholders, and JSON that is not valid with the URI in place.
  for (const char* uri : {"@0", "@1", "@", "@-1", "@0x", "@99999999999999999999"})
    EXPECT_NE(glb_of(with(data, uri)).find("names a file"), std::string::npos) << uri;
  EXPECT_NE(glb_of(with("\"VTK\"", "\"VTK\"data:x\"")).find("not glTF in JSON"), std::string::npos);
  EXPECT_NE(glb_of(with("AAAA\"", "AAAA")).find("not glTF in JSON"), std::string::npos);
  EXPECT_NE(glb_of(with("AAAA", "\xff")).find("octet-stream"), std::string::npos);
}

template <typename Value>
Value value_at(const std::string& file, size_t offset) {
  Value value;
  std::memcpy(&value, file.data() + offset, sizeof value);
  return value;
}

// Value of a tag in the first directory of a little-endian TIFF file.
uint32_t tag(const std::string& file, uint16_t wanted) {
  const auto directory = value_at<uint32_t>(file, 4);
  for (uint16_t i = 0; i < value_at<uint16_t>(file, directory); ++i) {
    const size_t entry = directory + 2u + 12u * i;
    if (value_at<uint16_t>(file, entry) == wanted) return value_at<uint32_t>(file, entry + 8);
  }
  return UINT32_MAX;
}

TEST(DrakeDepth, TiffIsMetresOrMillimetres) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::vector<float> depths{kInfinity, 5.0f, 4.9999f, 1.2344f, 0.1f, 0.05f};
  const std::string metres = encode_depth(depths, 3, 2, {0.1, 5}, DepthFormat::float32_m);
  EXPECT_EQ(metres.substr(0, 4), std::string("II*\0", 4));
  EXPECT_EQ(tag(metres, 256), 3u);
  EXPECT_EQ(tag(metres, 257), 2u);
  EXPECT_EQ(tag(metres, 258), 32u);
  EXPECT_EQ(tag(metres, 339), 3u);
  EXPECT_EQ(tag(metres, 273) + 24u, metres.size());
  // Far and beyond: infinity. 0.1f is above 0.1, 0.05 is too near.
  const float wanted[] = {kInfinity, kInfinity, 4.9999f, 1.2344f, 0.1f, 0};
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ(value_at<float>(metres, tag(metres, 273) + 4 * i), wanted[i]) << i;
  const std::string millimetres = encode_depth(depths, 3, 2, {0.1, 70}, DepthFormat::uint16_mm);
  EXPECT_EQ(tag(millimetres, 258), 16u);
  EXPECT_EQ(tag(millimetres, 339), 1u);
  const uint16_t wanted_mm[] = {65535, 5000, 5000, 1234, 100, 0};
  for (size_t i = 0; i < 6; ++i)
    EXPECT_EQ(value_at<uint16_t>(millimetres, tag(millimetres, 273) + 2 * i), wanted_mm[i]) << i;
  const std::string far = encode_depth(std::vector<float>{65.6f}, 1, 1, {0.1, 70}, DepthFormat::uint16_mm);
  EXPECT_EQ(value_at<uint16_t>(far, tag(far, 273)), 65535);
}

}  // namespace
}  // namespace fire3dv::drake
