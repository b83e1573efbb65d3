// Objects that the user adds to the displayed scene: lights, cameras, assets and duplicates of nodes, with
// unused names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "renderer/editing/edit_document.h"
#include "renderer/editing/view_state.h"
#include "renderer/live_scene/user_additions.h"

namespace fire3dv::app {

// View at the time of an addition.
struct EditorView {
  glm::vec3 focus_m{0};
  glm::mat4 world_from_camera{1};
  scene::Camera camera = {};
  const state::PoseState* poses = nullptr;  // null: the scene rests
};

struct NewObject {
  std::string name;
  state::Addition addition;
  state::EditDocument edits = {};  // of its nodes
};

// A light at the focus point, or a camera at the view's position.
NewObject new_object(ObjectKind kind, const EditorView& view, const state::EditDocument& document,
                     const state::EditTargets& targets);
// Of a file, at the focus point.
NewObject new_asset(const std::string& uri, const EditorView& view, const state::EditDocument& document,
                    const state::EditTargets& targets);
// glTF files of the overlay file's folder, of that of --assets (empty: none) and of the folders in them, as
// URIs that AssetFolder resolves to them; at most 200. 10 000 entries of each folder are looked at.
std::vector<std::string> offered_assets(const std::filesystem::path& overlay,
                                        const std::filesystem::path& assets);
// Name of the file of such a URI without its ending, printable.
std::string name_of_asset(std::string_view uri);
// True if the document adds a node of this name that may have a camera, when it is displayed.
bool may_add_camera(const state::EditDocument& document, const std::string& name);
// Its index among the scene's cameras, for --camera. shown: additions whose nodes the scene has.
Result<size_t> find_added_camera(const std::string& name, const scene::Scene& scene,
                                 std::span<const ShownAddition> shown);
// Like the node as it is shown now, beside it. An error if its path is not its own.
Result<NewObject> duplicate(uint32_t node, const EditorView& view, const state::EditDocument& document,
                            const state::EditTargets& targets);

}  // namespace fire3dv::app
