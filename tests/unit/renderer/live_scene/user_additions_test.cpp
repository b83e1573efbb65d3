// Test of the user's additions as requests of a scene build: keys of the files that they name, and refusals.
#include "renderer/live_scene/user_additions.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "renderer/editing/asset_digest.h"
#include "renderer/editing/document_additions.h"
#include "renderer/live_scene/asset_files.h"
#include "tests/support/gltf_builder.h"

namespace fire3dv::app {
namespace {

state::RequestedNode with_asset(const std::string& uri, bool is_of_user, const std::string& variant = "") {
  auto added = std::make_shared<wire::NodeAdded>();
  added->asset_uri = uri;
  added->variant = variant;
  state::RequestedNode node;
  node.added = std::move(added);
  if (is_of_user)
    node.addition = std::make_shared<const state::Addition>(state::Addition{{}, {}, state::AddedAsset{uri}});
  return node;
}

TEST(AssetFiles, FileAliasesShareAKey) {
  test::ScratchFolder folder;
  std::filesystem::create_directory(folder.path() / "sub");
  folder.write("sub/a.glb", "a");
  folder.write("b.glb", "b");
  AssetFiles files({}, folder.path() / "scene.overlay.json");
  const std::string key = files.key(with_asset("sub/a.glb", true));
  for (const char* uri : {"./sub/a.glb", "sub//a.glb", "sub/./a.glb", "sub/%61.glb", "%73ub/a.glb"})
    EXPECT_EQ(files.key(with_asset(uri, true)), key) << uri;
  EXPECT_NE(files.key(with_asset("b.glb", true)), key);
  EXPECT_NE(files.key(with_asset("sub/a.glb", true, "red")), key);
  EXPECT_NE(files.key(with_asset("sub/a.glb", false)), key) << "a stream's folder is another one";
}

TEST(AssetFiles, LaterFileIsFoundAfterForget) {
  test::ScratchFolder folder;
  AssetFiles files({}, folder.path() / "scene.overlay.json");
  const std::string missing = files.key(with_asset("a.glb", true));
  EXPECT_NE(files.key(with_asset("./a.glb", true)), missing);
  folder.write("a.glb", "a");
  EXPECT_EQ(files.key(with_asset("a.glb", true)), missing) << "keys stay during a build";
  files.forget_missing();
  const std::string found = files.key(with_asset("a.glb", true));
  EXPECT_NE(found, missing);
  EXPECT_EQ(files.key(with_asset("./a.glb", true)), found);
}

TEST(AssetFiles, DigestIsOfContents) {
  test::ScratchFolder folder;
  const AssetFiles files({}, folder.path() / "scene.overlay.json");
  const auto never = [] { return false; };
  state::EditDocument document;
  state::Addition lamp;
  lamp.content = scene::Light();
  document[state::key_of_addition("lamp")] = lamp;
  EXPECT_EQ(digest_of_assets(document, files, never), "");
  state::Addition rock;
  rock.content = state::AddedAsset{"rock.glb"};
  document[state::key_of_addition("rock")] = rock;
  test::GltfBuilder triangle = test::triangle_file();
  const std::string missing = digest_of_assets(document, files, never);
  folder.write("rock.glb", triangle.glb());
  const std::string first = digest_of_assets(document, files, never);
  EXPECT_EQ(first.size(), 32u);
  EXPECT_NE(first, missing);
  EXPECT_EQ(digest_of_assets(document, files, never), first);
  triangle.root["nodes"][0]["translation"] = {0, 0, 1};
  folder.write("rock.glb", triangle.glb());
  EXPECT_NE(digest_of_assets(document, files, never), first);
}

class RefusedAdditions : public testing::Test {
 protected:
  RefusedAdditions() {
    additions_["lamp"].content = scene::Light();
    additions_["rock"].content = state::AddedAsset{"rock.glb"};
    requests_.set(additions_);
  }
  state::RequestedNode request(const std::string& name) const {
    for (const state::RequestedNode& node : requests_.requests()) {
      if (node.name == name) return node;
    }
    ADD_FAILURE() << name << " is not requested";
    return {};
  }
  std::vector<std::string> requested() const {
    std::vector<std::string> names;
    for (const state::RequestedNode& node : requests_.requests()) names.push_back(node.name);
    return names;
  }
  using Names = std::vector<std::string>;

  state::Additions additions_;
  UserAdditions requests_;
};

TEST_F(RefusedAdditions, ChangesRetryThem) {
  EXPECT_TRUE(requests_.refused(9).empty());
  EXPECT_TRUE(requests_.refuse(request("lamp"), "no parent"));
  EXPECT_EQ(requests_.refused(9), (std::vector{std::pair<std::string, std::string>("lamp", "no parent")}));
  EXPECT_TRUE(requests_.refused(0).empty());
  EXPECT_EQ(requested(), (Names{"rock"}));
  requests_.set(additions_);
  EXPECT_EQ(requested(), (Names{"rock"})) << "nothing has changed";
  additions_["parent"].content = scene::Light();
  const uint64_t revision = requests_.revision();
  EXPECT_TRUE(requests_.set(additions_).empty());
  EXPECT_GT(requests_.revision(), revision);
  EXPECT_EQ(requested(), (Names{"lamp", "parent", "rock"}));
  EXPECT_FALSE(requests_.refuse(request("lamp"), "no parent")) << "reported already";
}

TEST_F(RefusedAdditions, OutOfMemoryWaitsForEnd) {
  requests_.refuse(request("rock"), "too large", true);
  additions_["other"].content = scene::Light();
  requests_.set(additions_);
  EXPECT_EQ(requested(), (Names{"lamp", "other"}));
  additions_.erase("lamp");
  EXPECT_EQ(requests_.set(additions_).size(), 1u);
  EXPECT_EQ(requested(), (Names{"other", "rock"}));
}

TEST_F(RefusedAdditions, AssetsAndCopiesAreLarge) {
  EXPECT_FALSE(UserAdditions::may_be_large(request("lamp")));
  EXPECT_TRUE(UserAdditions::may_be_large(request("rock")));
  EXPECT_FALSE(UserAdditions::may_be_large(with_asset("rock.glb", false))) << "streams have budgets";
}

}  // namespace
}  // namespace fire3dv::app
