// Panel classes. Each reads Shown and Facts and writes the user's requests to ViewState; members hold only UI
// state.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/gui/gui.h"
#include "renderer/gui/scalar_table.h"
#include "renderer/gui/widgets.h"

namespace fire3dv::settings {
struct DrawSetting;
struct DrawSettings;
}  // namespace fire3dv::settings

namespace fire3dv::gui {

struct Context {
  Ui& ui;
  const Facts& facts;
  const Shown& shown;
  app::ViewState& view_state;
  Layout& layout;
};

// Ring of the newest values, oldest first.
class History {
 public:
  static constexpr size_t kMaxSamples = 160;
  void add(float value);
  std::span<const float> values() const { return values_; }
  float median() const;
  void clear() { values_.clear(); }

 private:
  std::vector<float> values_;
};

class FramePanel {
 public:
  void note(const FrameFacts& facts);  // call once per image, whether open or not: histories have no gaps
  void draw(const Context& context);

 private:
  void draw_passes(const Context& context);
  uint64_t images_ = 0;
  History interval_ms_, cpu_ms_, gpu_ms_;
  std::map<std::string, History, std::less<>> pass_ms_;
  std::vector<std::string> pass_order_;
  std::string plotted_;  // pass name; empty: CPU and GPU
};

class StreamsPanel {
 public:
  void draw(const Context& context);

 private:
  void draw_stream(const Context& context, const StreamFact& stream);
};

// Curves of scalars over simulation time. The range of time follows the whole history until the user zooms
// (wheel), pans (drag) or pauses; a click pins the cursor.
class PlotsPanel {
 public:
  static constexpr size_t kMaxChosen = 8;  // one colour each
  void draw(const Context& context);
  bool takes_wheel() const { return takes_wheel_; }  // the column does not scroll meanwhile

 private:
  struct Entry {
    // Valid for this frame. Texts are made for shown rows only: a stream may have thousands of long names.
    const std::string* stream = nullptr;
    const std::string* group_name = nullptr;
    const stream::ScalarGroup* group = nullptr;
    size_t scalar = 0;
    std::optional<double> shown_ns;  // simulation time of the stream's shown frame
    ImU32 color = theme::palette->dim;
    bool chosen = false;

    const std::string& scalar_name() const { return group->declared().names[scalar]; }
    std::string name() const { return *group_name + "/" + scalar_name(); }
    // Stream and name: stays the same when the stream restarts.
    std::string key() const { return *stream + '\n' + name(); }
    bool has_key(std::string_view key) const;
  };
  static int64_t clamped_ns(double time_ns);
  void list(const Context& context);
  void draw_plot(const Context& context);
  void move_view(float width, float left, bool hovered, bool held, bool clicked);
  void draw_list(const Context& context);
  void draw_row(const Context& context, const Entry& entry, std::optional<double> cursor);
  std::optional<double> cursor_ns() const { return hovered_ns_ ? hovered_ns_ : pinned_ns_; }

  std::array<std::string, kMaxChosen> chosen_;  // keys; empty: free
  std::array<double, 2> view_{0, 1e9};          // shown range, in ns
  std::optional<std::array<double, 2>> fixed_;  // by the user
  std::optional<double> hovered_ns_, pinned_ns_;
  std::string search_;
  bool takes_wheel_ = false;
  // Of this frame.
  std::vector<Entry> entries_;
  std::vector<ScalarColumn> columns_;  // chosen ones
  std::vector<size_t> listed_;
  std::optional<double> shown_ns_;
};

// Scene tree. Lays out only visible rows, and recomputes expansion and search only on changes: a scene may
// have a hundred thousand nodes.
class TreePanel {
 public:
  void draw(const Context& context, float height_px);
  uint32_t rows_drawn() const { return rows_drawn_; }

 private:
  struct Row {
    uint32_t node, depth;
  };
  void take_scene(const scene::Scene& scene, uint64_t number);
  void list_rows(const scene::Scene& scene);
  void reveal(const scene::Scene& scene, uint32_t node);
  void draw_row(const Context& context, const Row& row);
  bool has_children(uint32_t node) const { return first_child_[node] != first_child_[node + 1]; }

  const scene::Scene* scene_ = nullptr;
  uint64_t scene_number_ = 0;
  std::vector<uint32_t> children_, first_child_, roots_;  // children of all nodes, concatenated
  std::vector<bool> open_;
  std::vector<uint64_t> path_hashes_;  // of the nodes' paths, to find them in the next scene
  std::vector<Row> rows_;
  bool rows_are_old_ = true;
  std::string search_;
  uint32_t revealed_ = scene::kNone;  // selection that the list was last scrolled to
  bool scroll_to_selection_ = false;
  uint32_t rows_drawn_ = 0;
};

void draw_node_panel(const Context& context);
void draw_edit_panel(const Context& context);
// Nothing if the scene has no robot.
void draw_joints_panel(const Context& context);

// Controls and run bars that streams declare. Nothing if there are none.
class ControlsPanel {
 public:
  struct Edited {  // text that is being typed
    uint64_t epoch = 0;
    std::string name, text;
  };
  void draw(const Context& context);

 private:
  Edited edited_;
};

// Coordinates of picked points and the distance between two of them.
void draw_measure_panel(const Context& context);

class CamerasPanel {
 public:
  void draw(const Context& context);

 private:
  std::vector<uint32_t> nodes_;  // camera nodes of scene scene_number_
  uint64_t scene_number_ = UINT64_MAX;
};

class MaterialsPanel {
 public:
  void draw(const Context& context);

 private:
  void list(const Context& context);
  // Chooses the first material of a node that was selected elsewhere.
  void follow(const scene::Scene& scene, uint32_t selected);
  uint32_t chosen_ = 0, followed_ = scene::kNone;
  bool of_selection_ = false, scrolls_to_chosen_ = false;
  uint64_t scene_number_ = 0;
  uint32_t listed_for_ = scene::kNone;
  bool listed_of_selection_ = false;
  const scene::Scene* scene_ = nullptr;
  std::vector<uint32_t> listed_;
};

class LightsPanel {
 public:
  void draw(const Context& context);

 private:
  void draw_light(const Context& context, uint32_t node, const scene::Light& light);
  uint32_t open_ = scene::kNone;  // node index
};

void draw_render_panel(const Context& context);
// Controls of a setting, if windows may set it.
void draw_setting_row(Ui& ui, const settings::DrawSetting& setting, settings::DrawSettings& draw);

class LogPanel {
 public:
  void draw(const Context& context);
  float lines_px() const { return lines_px_; }  // height of the lines in the last frame; 0: closed

 private:
  float lines_px_ = 0;
  uint64_t seen_ = 0, cleared_ = 0;  // values of Facts::log_lines
};

void draw_timeline_panel(const Context& context);
void draw_help(const Context& context);
// Text of EditFacts::notice at the top of the image.
void draw_notice(const Context& context, const Rect& image);
// Question of EditFacts::recovered there, with buttons.
void draw_recovery(const Context& context, const Rect& image);

// Numbers for display: "1 234 567", "1.2 M", "3.4 GiB".
std::string grouped(uint64_t number);
std::string path_progress_text(const settings::PathProgress& paths);  // 12 / 256 samples
std::string short_number(double number);
std::string bytes_text(uint64_t bytes);
// What rounding leaves of a 0 beside the largest coordinate becomes 0.
glm::vec3 without_rounding(glm::vec3 vector);
bool contains_no_case(std::string_view text, std::string_view wanted);
// Node name, or a substitute for unnamed nodes.
std::string node_label(const scene::Scene& scene, uint32_t node);

}  // namespace fire3dv::gui
