// Security test of asset URIs: none leads out of the asset's folder, to the network, or to a special file.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdio>

#include "renderer/scene/files.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::scene {
namespace {

namespace fs = std::filesystem;

class SceneFiles : public testing::Test {
 protected:
  SceneFiles() {
    folder_.write("secret.bin", builder_.bin);
    folder_.write("asset/inside.bin", builder_.bin);
    folder_.write("asset/sub/deeper.bin", builder_.bin);
    folder_.write("asset-beside/near.bin", builder_.bin);
  }

  // Tests the URI as buffer and as image. No bytes here are an image: the buffer decides, and the image
  // becomes a placeholder for the same reason.
  std::string outcome(const std::string& uri) {
    const auto scene = load_gltf(folder_.write("asset/scene.gltf", builder_.gltf(uri)));
    test::GltfBuilder with_image = builder_;
    with_image.add_textured_material(test::png(1, 1, 0));
    with_image.root["images"][0] = {{"uri", uri}};
    const auto image = load_gltf(folder_.write("asset/image.glb", with_image.glb()));
    EXPECT_TRUE(image.ok()) << image.error().message;
    const std::string warning = image && image->warnings.size() == 1 ? image->warnings[0] : "";
    EXPECT_TRUE(warning.starts_with("images[0]")) << uri << ": " << warning;
    if (scene) {
      EXPECT_NE(warning.find("none of PNG, JPEG, WebP and KTX 2.0"), std::string::npos)
          << uri << ": " << warning;
      return "loaded";
    }
    const std::string fault = scene.error().message;
    const size_t reason = fault.find("buffers[0]: ");
    EXPECT_NE(reason, std::string::npos) << fault;
    if (reason != std::string::npos && fault.find("byteLength") == std::string::npos) {
      EXPECT_NE(warning.find(fault.substr(reason + 12)), std::string::npos) << fault << "\n" << warning;
    }
    return fault;
  }

  test::GltfBuilder builder_ = test::triangle_file();
  test::ScratchFolder folder_;
};

TEST_F(SceneFiles, PathsInFolderAreRead) {
  for (const char* uri : {"inside.bin", "./inside.bin", "sub/deeper.bin", "sub//deeper.bin", "%69nside.bin",
                          "sub%2Fdeeper.bin"}) {
    EXPECT_EQ(outcome(uri), "loaded") << uri;
  }
}

TEST_F(SceneFiles, OutsidePathsAreRefused) {
  const std::string secret = (folder_.path() / "secret.bin").string();
  for (const std::string& uri : {std::string("../secret.bin"),
                                 std::string("sub/../../secret.bin"),
                                 std::string("sub/../inside.bin"),
                                 std::string("%2e%2e/secret.bin"),
                                 std::string("%2E%2E%2Fsecret.bin"),
                                 std::string(".%2e/secret.bin"),
                                 std::string("../asset-beside/near.bin"),
                                 secret,
                                 "file:" + secret,
                                 "file://" + secret,
                                 "FILE://" + secret,
                                 "%66ile:" + secret,
                                 std::string("..\\secret.bin"),
                                 std::string("%2fetc%2fpasswd"),
                                 std::string("//host/secret.bin"),
                                 std::string("http://127.0.0.1:1/x"),
                                 std::string("https://example.com/x"),
                                 std::string("~/secret.bin"),
                                 std::string("$(touch pwned)"),
                                 std::string("`touch pwned`"),
                                 std::string("inside.bin%00.png"),
                                 std::string("%zz"),
                                 std::string("inside.bin%2"),
                                 std::string("missing.bin"),
                                 std::string(".")}) {
    EXPECT_NE(outcome(uri), "loaded") << uri;
  }
  EXPECT_FALSE(fs::exists(folder_.path() / "asset/pwned"));
}

TEST_F(SceneFiles, InsideLinksAreFollowed) {
  fs::create_symlink("inside.bin", folder_.path() / "asset/good.bin");
  fs::create_symlink("../secret.bin", folder_.path() / "asset/bad.bin");
  fs::create_directory_symlink("..", folder_.path() / "asset/up");
  fs::create_directory_symlink("../asset-beside", folder_.path() / "asset/beside");
  EXPECT_EQ(outcome("good.bin"), "loaded");
  EXPECT_NE(outcome("bad.bin").find("leaves the asset's folder"), std::string::npos);
  EXPECT_NE(outcome("up/secret.bin"), "loaded");
  EXPECT_NE(outcome("beside/near.bin"), "loaded");
}

TEST_F(SceneFiles, PipesAndFoldersAreRefused) {
  ASSERT_EQ(mkfifo((folder_.path() / "asset/pipe").c_str(), 0600), 0);
  EXPECT_NE(outcome("pipe").find("not a regular file"), std::string::npos);
  EXPECT_NE(outcome("sub").find("not a regular file"), std::string::npos);
  const auto scene = load_gltf(folder_.path() / "asset");
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("not a regular file"), std::string::npos);
}

TEST_F(SceneFiles, DataUris) {
  EXPECT_EQ(outcome(test::data_uri(builder_.bin)), "loaded");
  for (const char* uri :
       {"data:", "data:,abc", "data:;base64", "data:;base64,", "data:;base64,AAA!", "data:;base64,A"}) {
    EXPECT_NE(outcome(uri), "loaded") << uri;
  }
}

TEST_F(SceneFiles, PercentEncodedDataUris) {
  std::string uri = "data:application/octet-stream,";
  for (const std::byte byte : builder_.bin) {
    char escape[4];
    std::snprintf(escape, sizeof escape, "%%%02x", static_cast<unsigned>(byte));
    uri += escape;
  }
  EXPECT_EQ(outcome(uri), "loaded");
  std::string base64 = test::data_uri(builder_.bin);
  for (size_t at = base64.find(',') + 1; (at = base64.find('A', at)) != std::string::npos;)
    base64.replace(at, 1, "%41");
  EXPECT_EQ(outcome(base64), "loaded");
  EXPECT_NE(outcome("data:,%zz").find("broken percent escape"), std::string::npos);

  const AssetFolder folder("scene.gltf");
  const auto text = folder.read("data:text/plain;charset=UTF-8,a%20b%00c,d", 100);
  ASSERT_TRUE(text.ok());
  const std::string_view expected("a b\0c,d", 7);
  EXPECT_EQ(std::string_view(reinterpret_cast<const char*>(text->data.get()), text->size), expected);
  const auto none = folder.read("data:,", 100);
  ASSERT_TRUE(none.ok());
  EXPECT_EQ(none->size, 0u);
}

TEST(SceneBase64, EveryLengthComesBack) {
  const AssetFolder folder("scene.gltf");
  for (size_t size = 0; size < 10; ++size) {
    std::vector<std::byte> bytes(size);
    for (size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 37 + 200);
    const auto read = folder.read(test::data_uri(bytes), 100);
    ASSERT_TRUE(read.ok());
    EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), read->view().begin(), read->view().end())) << size;
  }
}

TEST(SceneFilesMissing, TheFileItself) {
  const auto scene = load_gltf("/nonexistent/scene.glb");
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.error().message.find("/nonexistent/scene.glb"), std::string::npos);
  EXPECT_NE(scene.error().message.find("No such file"), std::string::npos);
}

TEST(SceneFilesMissing, MessagesHaveNoControls) {
  EXPECT_EQ(quote("a\nb\x1b[31m"), "\"a?b?[31m\"");
  EXPECT_EQ(quote("C1 \xC2\x9B"
                  "31m, turned \xE2\x80\xAE"
                  "txt.exe, \xE2\x81\xA6, \xFF"),
            "\"C1 ?31m, turned ?txt.exe, ?, ?\"");
  EXPECT_EQ(quote("stra\xC3\x9F"
                  "e"),
            "\"stra\xC3\x9F"
            "e\"");
}

}  // namespace
}  // namespace fire3dv::scene
