// Fuzz target of Drake's render requests: the multipart parser and the split of the scene. Parts are views of
// the body, in order; a scene that is read can be written as .glb.
#include <string>
#include <string_view>

#include "programs/drake/http/multipart.h"
#include "programs/drake/request/gltf_scene.h"
#include "tests/fuzz/target.h"

namespace fire3dv::fuzz {
namespace {

constexpr std::string_view kScene =
    R"({"scenes":[{"nodes":[2]}],"nodes":[{"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,1,2,3,1],"mesh":0},)"
    R"({"camera":0,"rotation":[0,0,0,1],"name":"Camera Node"},{"children":[0,1]}],"cameras":[{}],)"
    R"("materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.2,0.4,0,1]}}],)"
    R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],)"
    R"("buffers":[{"uri":"data:;base64,AAAA"}],"images":[{"uri":"data:image/png;base64,AA"}]})";

}  // namespace

std::vector<Input> seeds() {
  std::vector<Input> inputs;
  const std::string form =
      "--b\r\nContent-Disposition: form-data; name=\"width\"\r\n\r\n640\r\n--b \r\nX: y\r\n"
      "content-disposition: form-data; filename=\"a\\\"b\"; name=scene\r\n\r\n{}\r\n--b\r\n\r\n\r\n--b--\r\n";
  for (const std::string_view text : {std::string_view(form), kScene})
    inputs.emplace_back(text.begin(), text.end());
  return inputs;
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv;
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  if (const auto parts = drake::parse_multipart(input, "multipart/form-data; boundary=b")) {
    const char* at = input.data();
    for (const drake::FormPart& part : *parts) {
      FIRE3DV_ASSERT(part.data.data() >= at && part.data.data() + part.data.size() <= input.data() + size);
      FIRE3DV_ASSERT(part.data.find("\r\n--b") == std::string_view::npos);
      at = part.data.data() + part.data.size();
    }
  }
  (void)drake::parse_multipart("--b--", input);
  for (const drake::ImageType type : {drake::ImageType::color, drake::ImageType::label}) {
    auto scene = drake::GltfScene::read(input, type);
    if (scene) FIRE3DV_ASSERT(scene->take_glb().size() > 20);
  }
  return 0;
}
