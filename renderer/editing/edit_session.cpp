#include "renderer/editing/edit_session.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <set>
#include <string_view>
#include <system_error>

#include "base/clock.h"
#include "base/files.h"
#include "base/log.h"
#include "base/plural.h"
#include "base/text.h"
#include "renderer/editing/overlay_file.h"
#include "renderer/editing/target_index.h"
#include "renderer/editing/view_transfer.h"
#include "renderer/scene/gltf/export/export_glb.h"
#include "renderer/scene/model/bounds.h"

namespace fire3dv::app {
namespace {

bool is_there(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::exists(std::filesystem::symlink_status(path, error));
}

// Size of a new node with all below it. With a hint for sizes that a file in other units than metres has:
// such a surface may be around the camera, or too small to be seen. Empty for lights and cameras.
std::string size_text(const scene::Scene& before, const scene::Scene& after, uint32_t top) {
  constexpr float kMaxRatio = 20, kMinRatio = 1e-3f;
  const std::vector<glm::mat4> world_from_node = state::rest_pose(after).world_from_node;
  std::vector<bool> below(after.nodes.size(), false);
  scene::Box box;
  for (uint32_t node = top; node < after.nodes.size(); ++node) {
    const uint32_t parent = after.nodes[node].parent;
    below[node] = node == top || (parent != scene::kNone && below[parent]);
    if (!below[node]) continue;
    const scene::Box part = scene::bounds_in_world(after, node, world_from_node);
    if (!part.empty()) box.add(part);
  }
  if (box.empty()) return "";
  const glm::vec3 size = box.high - box.low;
  char text[96];
  std::snprintf(text, sizeof text, ", %.3g x %.3g x %.3g m", static_cast<double>(size.x),
                static_cast<double>(size.y), static_cast<double>(size.z));
  const float scene_m = glm::length(before.bounds_max - before.bounds_min);
  const float ratio = glm::length(size) / scene_m;
  if (!(scene_m > 0) || (ratio < kMaxRatio && ratio > kMinRatio)) return text;
  char hint[160];
  std::snprintf(
      hint, sizeof hint,
      "; it is %.0f times as %s as the scene: if its file is not in metres, set Scale (centimetres: "
      "0.01), then press F",
      static_cast<double>(ratio > 1 ? ratio : 1 / ratio), ratio > 1 ? "large" : "small");
  return std::string(text) + hint;
}

void add_exported(const scene::Scene& scene, const ShownAddition& shown, const state::Addition& addition,
                  scene::ExportedEdits& edits) {
  scene::ExportedNode root{shown.root, scene.nodes[shown.root].parent, shown.name};
  if (const auto* light = std::get_if<scene::Light>(&addition.content)) root.light = *light;
  if (const auto* camera = std::get_if<scene::Camera>(&addition.content)) root.camera = *camera;
  if (!shown.sources.empty()) root.copied = shown.sources.front();
  if (std::holds_alternative<state::AddedAsset>(addition.content))
    root.asset = scene::ExportedAsset{shown.asset.file, shown.asset.node_count, shown.asset.first_material,
                                      shown.asset.material_count, shown.asset.digest};
  const state::NodeTransform& parts = addition.transform;
  edits.transforms[shown.root] = {state::parent_from_node(parts), !parts.has_shear, parts.translation,
                                  parts.rotation, parts.scale};
  edits.added.push_back(std::move(root));
  for (size_t i = 1; i < shown.sources.size(); ++i) {
    const uint32_t node = shown.root + static_cast<uint32_t>(i);
    edits.added.push_back({node, scene.nodes[node].parent, {}, shown.sources[i]});
  }
  for (const uint32_t source : shown.sources) edits.names[source] = scene.nodes[source].name;
  const uint32_t parent = scene.nodes[shown.root].parent;
  if (parent != scene::kNone) edits.names[parent] = scene.nodes[parent].name;
}

// Edits by number, for a file of the scene's nodes.
scene::ExportedEdits exported_edits(const state::UserEdits& user, const state::EditTargets& targets,
                                    std::span<const ShownAddition> additions) {
  const scene::Scene& scene = targets.scene;
  state::RestPose pose = state::rest_pose(scene);
  if (targets.robot && targets.robot->is_moved()) {
    state::RobotPose robot = *targets.robot;
    robot.set_scene(scene, targets.names);
    robot.apply(pose);
  }
  state::apply_transforms(user.transforms, scene, pose);
  scene::ExportedEdits edits;
  edits.hidden = user.hidden;
  edits.removed = user.removed;
  edits.variant = user.variant;
  edits.lights = user.lights;
  edits.materials = user.materials;
  for (const ShownAddition& shown : additions) {
    const auto known = user.additions.find(shown.name);
    if (known == user.additions.end() || shown.root >= scene.nodes.size()) continue;
    add_exported(scene, shown, known->second, edits);
  }
  for (uint32_t node = 0; node < scene.nodes.size(); ++node) {
    const glm::mat4& matrix = pose.parent_from_node[node];
    if (matrix == scene.nodes[node].parent_from_node) continue;  // of the file, or of an addition
    const auto edited = user.transforms.find(node);
    const state::NodeTransform parts =
        edited != user.transforms.end() ? edited->second : state::to_transform(matrix);
    edits.transforms[node] = {matrix, !parts.has_shear, parts.translation, parts.rotation, parts.scale};
  }
  const auto name = [&](uint32_t node) {
    if (node < scene.nodes.size()) edits.names[node] = scene.nodes[node].name;
  };
  for (const uint32_t node : edits.hidden) name(node);
  for (const uint32_t node : edits.removed) name(node);
  for (const auto& [node, light] : edits.lights) name(node);
  for (const auto& [node, transform] : edits.transforms) name(node);
  return edits;
}

// One for each addition that is not displayed, and thus not exported.
std::vector<std::string> missing_additions(const state::Additions& additions,
                                           std::span<const ShownAddition> shown) {
  std::set<std::string_view> names;
  for (const ShownAddition& each : shown) names.insert(each.name);
  std::vector<std::string> messages;
  for (const auto& [name, addition] : additions) {
    if (!names.contains(name))
      messages.push_back(warning("export: node " + quote(name) +
                                 " is left out: it is not displayed; export again when it is"));
  }
  return messages;
}

// Writes a new file beside the scene; returns messages.
std::vector<std::string> write_glb(const std::filesystem::path& gltf, const scene::ExportedEdits& edits,
                                   std::filesystem::path scene) {
  constexpr int kMaxFiles = 1000;
  Result<scene::ExportedGlb> exported = scene::export_glb(gltf, edits);
  if (!exported) return {error_line("no .glb is written: " + exported.error().message)};
  std::vector<std::string> messages;
  for (const std::string& note : exported->warnings) messages.push_back(warning("export: " + note));
  scene.replace_extension();
  for (int number = 1; number <= kMaxFiles; ++number) {
    std::filesystem::path path = scene;
    path += number == 1 ? ".edited.glb" : ".edited-" + std::to_string(number) + ".glb";
    if (is_there(path)) continue;
    base::AtomicFileOptions options;
    options.replaces = false;
    if (const Result<void> written = base::write_atomically(path, {exported->bytes}, options); !written) {
      messages.push_back(error_line("no .glb is written: " + written.error().message));
    } else {
      messages.push_back("scene exported to " + path.string());
    }
    return messages;
  }
  messages.push_back(
      error_line("no .glb is written: there are too many such files beside " + scene.string()));
  return messages;
}

}  // namespace

namespace {

bool adds_files(const state::Additions& additions) {
  return std::ranges::any_of(additions, [](const auto& entry) {
    return std::holds_alternative<state::AddedAsset>(entry.second.content);
  });
}

std::string recovered_text(size_t edits) {
  return counted(edits, "edit") + " of an earlier run " + (edits == 1 ? "was" : "were") + " not saved";
}

bool is_same_folder(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code error;
  const auto folder = [&](const std::filesystem::path& file) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(file, error).parent_path(), error);
  };
  return folder(a) == folder(b);
}

}  // namespace

std::optional<Digest> digest_of_overlay(const std::filesystem::path& path) {
  if (path.empty() || !is_there(path)) return std::nullopt;
  const Result<Digest> digest = digest_of_file(path, state::kMaxOverlayBytes);
  return digest ? *digest : Digest{};
}

EditSession::EditSession(ViewState& view_state, OverlayFile file, state::EditDocument document)
    : view_state_(view_state),
      file_(std::move(file)),
      asset_names_from_(file_.path),
      replaceable_(file_.digest),
      is_known_(file_.was_named),
      assets_(offered_assets(file_.path, file_.assets)) {
  history_.reset(std::move(document));
  history_.mark_saved();
}

EditSession::~EditSession() {
  if (recovery_) (void)recovery_->keep(history_);
}

void EditSession::begin(const state::EditTargets& targets) {
  if (!file_.was_named && !file_.path.empty() && is_there(file_.path))
    notes_.push_back(file_.path.filename().string() + " beside the scene is not applied: --overlay " +
                     file_.path.string());
  if (history_.document().empty()) return;
  unmatched_.emplace();
  show(targets, &*unmatched_);
  if (view_state_.edits.additions.empty()) report_start(targets);
}

void EditSession::report_start(const state::EditTargets& targets) {
  constexpr size_t kMaxReported = 8;
  if (!unmatched_) return;
  std::vector<state::EditKey> unmatched = *std::exchange(unmatched_, std::nullopt);
  std::set<std::string_view> shown, refused;  // names of additions
  for (const ShownAddition& addition : shown_additions()) shown.insert(addition.name);
  state::Paths refused_paths;
  size_t applied = 0;
  state::TargetIndex index(targets);
  for (const auto& [key, value] : history_.document()) {
    const auto* const addition = std::get_if<state::Addition>(&value);
    if (addition && !shown.contains(key.name)) {
      refused.insert(key.name);
      refused_paths.insert(state::path_of(key.name, *addition));
    } else if (index.find(key, value) != scene::kNone) {
      // That of --variant is not the file's; if it is missing, the scene's load has failed.
      applied += file_.has_variant_option && key == state::variant_key() ? 0 : 1;
    }
  }
  // Edits of an addition that was refused have its warning.
  std::erase_if(unmatched, [&](const state::EditKey& key) {
    if (key.object == state::EditedObject::node && state::is_at_or_below(key.name, refused_paths))
      return true;
    if (key.object == state::EditedObject::material && refused.contains(key.owner)) return true;
    return index.find(key) != scene::kNone;
  });
  const std::string origin = file_.was_named ? file_.path.string() + ": " : std::string();
  for (size_t i = 0; i < std::min(unmatched.size(), kMaxReported); ++i)
    notes_.push_back(warning(origin + state::missing_target_text(unmatched[i], targets)));
  if (unmatched.size() > kMaxReported)
    notes_.push_back(
        warning(origin + counted(unmatched.size() - kMaxReported, "further edit") + " without effect"));
  if (file_.was_named && applied != 0)
    notes_.push_back(counted(applied, "edit") + " of " + file_.path.string() + " applied");
}

void EditSession::show(const state::EditTargets& targets, std::vector<state::EditKey>* unmatched) {
  view_state_.edits = state::to_edits(history_.document(), targets, view_state_.edits, unmatched);
  recorded_ = view_state_.edits;
}

// Edits of objects that the scene lacks are not displayed, and stay.
state::EditDocument EditSession::current(const state::EditTargets& targets) const {
  state::EditDocument document = state::to_document(view_state_.edits, targets);
  state::TargetIndex index(targets);
  for (const auto& [key, value] : history_.document()) {
    if (index.find(key, value) == scene::kNone) document.emplace(key, value);
  }
  return document;
}

// Of nodes that their paths name.
state::Paths EditSession::shown_paths(const state::EditTargets& targets) const {
  state::Paths paths;
  for (const ShownAddition& shown : shown_additions()) {
    if (shown.root >= targets.scene.nodes.size()) continue;
    const std::string& path = targets.scene.nodes[shown.root].path;
    if (targets.names.first_of_path(path) == shown.root) paths.insert(path);
  }
  return paths;
}

void EditSession::record(const state::EditTargets& targets) {
  UserEdits edits = view_state_.edits;
  if (edits == recorded_) return;
  state::EditDocument document = current(targets);
  const bool is_less = state::withdraw_removed_additions(document, shown_paths(targets));
  history_.record(std::move(document));
  recorded_ = std::move(edits);
  if (is_less) show(targets);
}

void EditSession::add(const state::EditTargets& targets, NewObject object) {
  state::EditDocument document = history_.document();
  selected_next_ = state::path_of(object.name, object.addition);
  document[state::key_of_addition(std::move(object.name))] = std::move(object.addition);
  document.merge(object.edits);
  history_.record(std::move(document));
  show(targets);
}

// With its edits, and with additions below it. Edits at its path are of another node if there is one.
void EditSession::remove_refused(const state::EditTargets& targets, const std::string& name) {
  state::EditDocument document = history_.document();
  const auto known = document.find(state::key_of_addition(name));
  if (known == document.end()) return;
  const std::string path = state::path_of(name, std::get<state::Addition>(known->second));
  if (targets.names.first_of_path(path) == scene::kNone) {
    state::EditKey removed{state::EditedObject::node, path, 0, state::EditedProperty::removed};
    document[std::move(removed)] = true;
    (void)state::withdraw_removed_additions(document, {path});
  } else {
    document.erase(known);
    std::erase_if(document, [&](const auto& edit) {
      return edit.first.object == state::EditedObject::material && edit.first.owner == name;
    });
  }
  history_.record(std::move(document));
  show(targets);
}

void EditSession::add_requested(const state::EditTargets& targets, const EditorView& view) {
  Commands& commands = view_state_.commands;
  if (std::exchange(commands.list_assets, false)) assets_ = offered_assets(file_.path, file_.assets);
  if (const auto kind = std::exchange(commands.add, std::nullopt))
    add(targets, new_object(*kind, view, history_.document(), targets));
  if (const auto uri = std::exchange(commands.add_asset, std::nullopt))
    add(targets, new_asset(*uri, view, history_.document(), targets));
  if (const auto name = std::exchange(commands.remove_addition, std::nullopt)) remove_refused(targets, *name);
  if (!std::exchange(commands.duplicate, false) || view_state_.selected >= targets.scene.nodes.size()) return;
  Result<NewObject> copy = duplicate(view_state_.selected, view, history_.document(), targets);
  if (!copy) return notes_.push_back(error_line("the node is not duplicated: " + copy.error().message));
  add(targets, std::move(*copy));
}

void EditSession::update(const state::EditTargets& targets, bool is_interacting, const EditorView& view) {
  if (is_interacting) return;
  record(targets);
  add_requested(targets, view);
  Commands& commands = view_state_.commands;
  const bool undone = std::exchange(commands.undo, false) && history_.undo();
  const bool redone = std::exchange(commands.redo, false) && history_.redo();
  if (undone || redone) {
    show(targets);
    settings_.restore(view_state_, history_);
  }
  if (const auto applies = std::exchange(commands.recover, std::nullopt)) decide_recovery(targets, *applies);
  if (std::exchange(commands.save_overlay, false)) save();
  if (const auto path = std::exchange(commands.save_as, std::nullopt)) save_as(*path);
  if (std::exchange(commands.export_glb, false)) export_glb(targets);
}

void EditSession::take_shown_variant(const state::EditTargets& targets) {
  state::EditDocument document = history_.document();
  document.erase(state::variant_key());
  if (view_state_.edits.variant < targets.scene.variants.size())
    document[state::variant_key()] = state::VariantName(targets.scene.variants[view_state_.edits.variant]);
  history_.set_document(std::move(document));
  if (recorded_) recorded_->variant = view_state_.edits.variant;
}

void EditSession::record_settings(bool is_interacting) {
  if (!is_interacting) settings_.record(view_state_, history_);
}

void EditSession::replace_scene(const scene::Scene& before, const scene::Scene& after,
                                const state::RobotPose* robot) {
  const std::span<const state::AddedMaterials> added = added_materials();
  const std::vector<state::AddedMaterials> added_before =
      std::exchange(materials_before_, {added.begin(), added.end()});
  const bool has_document = !history_.document().empty() || view_state_.edits != recorded_;
  if (!has_document && selected_next_.empty() && !refers_to_scene(view_state_)) return;
  const state::NodeNames names_before(before), names_after(after);
  const state::EditTargets from{before, names_before, robot, added_before};
  const state::EditTargets to{after, names_after, robot, added};
  state::EditDocument document;
  if (has_document) document = current(from);
  transfer_by_key(view_state_, from, to);
  if (!selected_next_.empty()) {
    const uint32_t next = names_after.first_of_path(selected_next_);
    if (next != scene::kNone) {
      view_state_.selected = next;
      notes_.push_back("added " + quote(std::exchange(selected_next_, {})) + size_text(before, after, next));
    }
  }
  if (!has_document) return;
  // Edits of objects that only one of the scenes has, beside those that were transferred.
  state::TargetIndex index_before(from), index_after(to);
  state::EditDocument next = state::to_document(view_state_.edits, to);
  for (const auto& [key, value] : document) {
    const bool was = index_before.find(key, value) != scene::kNone;
    const bool is = index_after.find(key, value) != scene::kNone;
    if (!was || !is) next.emplace(key, value);
  }
  // What could not be transferred is dropped from the document, without a step.
  state::EditDocument recorded;
  for (const auto& [key, value] : history_.document()) {
    if (next.contains(key) || !document.contains(key)) recorded.emplace(key, value);
  }
  history_.set_document(std::move(recorded));
  view_state_.edits = state::to_edits(next, to, view_state_.edits);
  recorded_.reset();  // compared by the next update()
}

// Joints keep their positions by their names.
void EditSession::replace_robot(const scene::Scene& scene, const state::RobotPose* before,
                                const state::RobotPose* after) {
  const state::NodeNames names(scene);
  const state::EditDocument document = current({scene, names, before, added_materials()});
  view_state_.edits = state::to_edits(document, {scene, names, after, added_materials()}, view_state_.edits);
  recorded_.reset();  // compared by the next update()
}

EditFacts EditSession::facts() const {
  EditFacts facts{history_.undo_text(), history_.redo_text(), history_.is_saved(), file_.path.string(),
                  assets_};
  if (recovery_ && recovery_->found()) facts.recovered = recovered_text(recovery_->found()->document.size());
  return facts;
}

// An overlay of an earlier run, or of another program, is not lost by one key press.
void EditSession::save() {
  if (file_.path.empty())
    return notes_.push_back(error_line(
        "the edits are not saved: the scene of a recording has no folder; start with --overlay FILE"));
  if (adds_files(view_state_.edits.additions) && !is_same_folder(file_.path, asset_names_from_))
    return notes_.push_back(
        error_line("the edits are not saved: the files that they add are named from the "
                   "folder of " +
                   asset_names_from_.string() + "; choose a name in that folder"));
  if (const std::optional<Digest> now = digest_of_overlay(file_.path); now && now != replaceable_) {
    replaceable_ = now;
    return notes_.push_back(warning(
        file_.path.string() +
        (is_known_ ? " was changed by another program: save again to replace its edits, or save under "
                     "another name"
                   : " exists and was not opened: save again to replace it, save under another name, or "
                     "start with --overlay FILE to go on with it")));
  }
  if (const Result<void> saved = state::save_overlay(file_.path, history_.document(), file_.scene); !saved)
    return notes_.push_back(error_line("the edits are not saved: " + saved.error().message));
  replaceable_ = digest_of_overlay(file_.path);
  is_known_ = true;
  history_.mark_saved();
  const std::string saved = counted(history_.document().size(), "edit") + " saved to " + file_.path.string();
  notes_.push_back(file_.was_named ? saved : saved + "; open it with --overlay " + file_.path.string());
}

void EditSession::save_as(const std::filesystem::path& path) {
  if (path != file_.path) {
    file_.path = path;
    file_.was_named = true;
    replaceable_.reset();
    is_known_ = false;
  }
  save();
}

// On a thread of its own: files may be large.
void EditSession::export_glb(const state::EditTargets& targets) {
  if (!export_.gltf_file)
    return notes_.push_back(error_line("no .glb is written: the scene of a recording has no folder"));
  if (exporting_.valid()) return notes_.push_back(warning("an export is being written already"));
  const std::span<const ShownAddition> shown = shown_additions();
  for (std::string& message : missing_additions(view_state_.edits.additions, shown))
    notes_.push_back(std::move(message));
  exporting_ =
      std::async(std::launch::async,
                 [gltf = export_.gltf_file(), edits = exported_edits(view_state_.edits, targets, shown),
                  scene = export_.scene] { return write_glb(gltf, edits, scene); });
}

std::vector<std::string> EditSession::take_log_messages() {
  const bool is_done =
      exporting_.valid() && exporting_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  return is_done ? finish() : std::exchange(notes_, {});
}

void EditSession::offer_recovery(bool has_window) {
  recovery_.emplace(file_.path, file_.scene, history_.document());
  for (std::string& note : recovery_->take_log_messages()) notes_.push_back(std::move(note));
  if (const std::optional<RecoveryFile::Found>& found = recovery_->found())
    notes_.push_back(warning(recovered_text(found->document.size()) + ": " + found->path.string() +
                             (has_window ? "; apply or discard them in the window"
                                         : "; --overlay " + found->path.string() + " applies them")));
  if (!has_window) recovery_.reset();
}

// Edits of this run stay where the recovered ones say nothing.
void EditSession::decide_recovery(const state::EditTargets& targets, bool applies) {
  if (!recovery_ || !recovery_->found()) return;
  if (!applies) {
    recovery_->discard_found();
    return notes_.push_back("the edits of the earlier run are discarded");
  }
  state::EditDocument document = recovery_->take_found();
  const size_t count = document.size();
  state::EditDocument own = history_.document();
  document.merge(own);
  history_.record(std::move(document));
  show(targets);
  notes_.push_back(counted(count, "edit") + " of the earlier run applied; " +
                   (file_.path.empty() ? "" : "Ctrl+S saves, ") + "Ctrl+Z takes them back");
}

void EditSession::protect_unsaved() {
  if (!recovery_) return;
  recovery_->update(history_, monotonic_ns());
  for (std::string& note : recovery_->take_log_messages()) notes_.push_back(std::move(note));
}

std::vector<std::string> EditSession::end(bool is_discarded) {
  std::vector<std::string> messages = finish();
  if (!recovery_) return messages;
  if (is_discarded || history_.is_saved()) {
    recovery_->remove();
  } else if (std::string kept = recovery_->keep(history_); !kept.empty()) {
    messages.push_back(warning(kept));
  }
  for (std::string& note : recovery_->take_log_messages()) messages.push_back(std::move(note));
  recovery_.reset();
  return messages;
}

std::vector<std::string> EditSession::finish() {
  std::vector<std::string> messages = std::exchange(notes_, {});
  if (exporting_.valid()) {
    for (std::string& message : exporting_.get()) messages.push_back(std::move(message));
  }
  return messages;
}

}  // namespace fire3dv::app
