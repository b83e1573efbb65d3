// Test of the user's additions as requests of a scene build: keys of the files that they name.
#include "renderer/app/loading/user_additions.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "renderer/app/loading/asset_files.h"
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

TEST(AssetFiles, NamesOfOneFileHaveOneKey) {
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

TEST(AssetFiles, AFileThatComesLaterIsFoundAfterForgetMissing) {
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

}  // namespace
}  // namespace fire3dv::app
