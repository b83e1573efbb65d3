// Editor of the displayed scene: the user's edits as a document, its undo history and its overlay file. The
// panels change ViewState; each finished interaction becomes a step. Independent of window and GPU; main
// thread only.
#pragma once

#include <filesystem>
#include <functional>
#include <future>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/digest.h"
#include "base/error.h"
#include "renderer/editing/document_additions.h"
#include "renderer/editing/edit_document.h"
#include "renderer/editing/edit_history.h"
#include "renderer/editing/new_objects.h"
#include "renderer/editing/recovery_file.h"
#include "renderer/editing/render_settings.h"
#include "renderer/editing/view_state.h"
#include "renderer/live_scene/live_scene.h"

namespace fire3dv::app {

// Overlay file of a scene.
struct OverlayFile {
  std::filesystem::path path;         // empty: there is nowhere to save
  std::string scene;                  // name of the scene, for readers of the file
  bool was_named = false;             // by the user, who wants it replaced
  bool has_variant_option = false;    // the document's variant is that of --variant, not the file's
  std::filesystem::path assets = {};  // folder of files that may be added, beside the file's own; empty: none
  std::optional<Digest> digest = {};  // of a named file before it was read; nullopt: there was none
};

// nullopt: no file. An unreadable one has the digest 0.
std::optional<Digest> digest_of_overlay(const std::filesystem::path& path);

// Source and name of exported scenes.
struct GlbExport {
  std::function<std::filesystem::path()> gltf_file;  // of the displayed scene; null: it has none of its own
  std::filesystem::path scene;                       // exported as SCENE.edited.glb, without its ending
};

class EditSession {
 public:
  // Borrows the view state, whose edits it records and sets.
  EditSession(ViewState& view_state, OverlayFile file, state::EditDocument document);
  ~EditSession();  // keeps unsaved edits, without end()

  // Makes the document the user's edits.
  void begin(const state::EditTargets& targets);
  // Reports the edits of the start that were applied, and those of objects that the scene lacks; once. Call
  // when the document's additions are displayed or refused; without any begin() does.
  void report_start(const state::EditTargets& targets);
  // Records finished changes of the user as a step, and executes its commands. Call after each layout.
  // is_interacting: a drag or a text input goes on, whose changes are one step. view: of the window.
  void update(const state::EditTargets& targets, bool is_interacting, const EditorView& view = {});
  // Takes the displayed material variant without a step, after the requested one was refused: undo and redo
  // go on from the shown one.
  void take_shown_variant(const state::EditTargets& targets);
  // Records changed render settings as a step. Call after the renderer has taken or reset them.
  void record_settings(bool is_interacting);
  // Moves selections and edits to the next scene. Edits of objects that a scene lacks stay in the document,
  // and take effect in a scene that has them. before and after are alive.
  void replace_scene(const scene::Scene& before, const scene::Scene& after, const state::RobotPose* robot);
  // After a reload: the robot of the displayed scene, in its file. null: none.
  void replace_robot(const scene::Scene& scene, const state::RobotPose* before,
                     const state::RobotPose* after);

  void set_export(GlbExport glb) { export_ = std::move(glb); }
  // Additions whose nodes the displayed scene has, and materials of files that were added to it, by the user
  // and by streams; without a call it has none. replace_scene() asks for those of the next scene.
  void set_shown_additions(std::function<std::span<const ShownAddition>()> shown,
                           std::function<std::span<const state::AddedMaterials>()> materials = {}) {
    shown_additions_ = std::move(shown);
    added_materials_ = std::move(materials);
  }

  const state::EditHistory& history() const { return history_; }
  EditFacts facts() const;
  std::vector<std::string> take_log_messages();
  // Waits for an export, and returns its messages, too.
  std::vector<std::string> finish();

  // Protects unsaved edits by a recovery file, and reports that of an earlier run: as a question in a window,
  // else as a sentence. Without a call there is none.
  void offer_recovery(bool has_window);
  // Writes the recovery file when it is due. Call often.
  void protect_unsaved();
  // finish() for the end of the run. is_discarded: by the user, who has closed the window.
  std::vector<std::string> end(bool is_discarded);

 private:
  state::EditDocument current(const state::EditTargets& targets) const;
  void show(const state::EditTargets& targets, std::vector<state::EditKey>* unmatched = nullptr);
  std::span<const ShownAddition> shown_additions() const {
    return shown_additions_ ? shown_additions_() : std::span<const ShownAddition>();
  }
  std::span<const state::AddedMaterials> added_materials() const {
    return added_materials_ ? added_materials_() : std::span<const state::AddedMaterials>();
  }
  state::Paths shown_paths(const state::EditTargets& targets) const;
  void record(const state::EditTargets& targets);
  void add_requested(const state::EditTargets& targets, const EditorView& view);
  void add(const state::EditTargets& targets, NewObject object);
  void remove_refused(const state::EditTargets& targets, const std::string& name);
  void save();
  void save_as(const std::filesystem::path& path);
  void export_glb(const state::EditTargets& targets);
  void decide_recovery(const state::EditTargets& targets, bool applies);

  ViewState& view_state_;
  OverlayFile file_;
  std::filesystem::path
      asset_names_from_;  // overlay file of the start; URIs of added files are relative to it
  // Digest of the file that the next save may replace: as it was read or saved last, or as the user was
  // warned of. nullopt: no file.
  std::optional<Digest> replaceable_;
  bool is_known_ = false;  // it was read or saved by this session
  state::EditHistory history_;
  RenderSettingsSteps settings_;
  std::optional<state::UserEdits> recorded_;              // edits at the last record
  std::vector<std::string> assets_;                       // offered ones
  std::optional<std::vector<state::EditKey>> unmatched_;  // at the start; nullopt: reported
  std::string selected_next_;  // path of an added node that the scene does not have yet
  std::vector<std::string> notes_;
  GlbExport export_;
  std::function<std::span<const ShownAddition>()> shown_additions_;
  std::function<std::span<const state::AddedMaterials>()> added_materials_;
  std::vector<state::AddedMaterials> materials_before_;  // of the scene of the last replace_scene()
  std::optional<RecoveryFile> recovery_;
  std::future<std::vector<std::string>> exporting_;  // its messages; last: it blocks the destructor
};

}  // namespace fire3dv::app
