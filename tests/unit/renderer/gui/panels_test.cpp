// Test of all controls of the panels: each has an effect when pressed, dragged or typed into. The enumeration
// that proves it includes every item that reacts to the mouse.
#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <optional>
#include <set>

#include "renderer/gui/layout_file.h"
#include "renderer/gui/panels.h"
#include "renderer/settings/setting_table.h"
#include "tests/unit/renderer/gui/gui_world.h"

namespace fire3dv::test {
namespace {

using gui::Control;
using Kind = gui::Control::Kind;

std::string numbers(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) text += std::to_string(value) + " ";
  return text;
}

// All state that the program acts on, as text.
std::string settings_of(const GuiWorld& world) {
  const app::ViewState& v = world.view_state;
  std::string text = numbers({double(v.selected), double(v.followed), double(v.edits.isolated),
                              v.camera_speed, double(v.gui), double(v.help), double(v.debug_view),
                              double(v.tool), double(v.tool_is_local), double(v.scale_is_uniform)});
  for (const uint32_t node : v.edits.removed) text += "removed " + std::to_string(node) + " ";
  for (const uint32_t node : v.edits.hidden) text += "hidden " + std::to_string(node) + " ";
  for (const auto& [node, light] : v.edits.lights) {
    text += "light " + numbers({double(node), light.color.r, light.color.g, light.color.b, light.intensity,
                                light.range_m, light.radius_m, light.spread, light.angular_radius_rad,
                                light.inner_cone_rad, light.outer_cone_rad, double(light.casts_shadow)});
  }
  for (const auto& [number, m] : v.edits.materials) {
    text += "material " + numbers({double(number), m.base_color.r, m.base_color.g, m.base_color.b,
                                   m.base_color.a, m.metallic, m.roughness, m.emissive.r, m.emissive.g,
                                   m.emissive.b, m.alpha_cutoff, m.normal_scale});
  }
  const settings::DrawSettings& d = v.draw;
  for (const settings::DrawSetting& setting : settings::draw_setting_table()) text += setting.text(d) + " ";
  text +=
      numbers({d.background.color.r, d.background.color.g, d.background.color.b,
               double(d.background.show_sky), double(v.paths.samples_per_pixel), double(v.paths.bounces)});
  for (const auto& [joint, position] : v.edits.joints)
    text += "joint " + numbers({double(joint), position[0]});
  for (const auto& [epoch, playout] : v.streams) {
    text += "stream " +
            numbers({double(epoch), double(playout.interpolate), double(playout.delay_ns.value_or(-1))});
  }
  for (const auto& [stream, name] : v.edits.hidden_markers) text += "markers " + stream + " " + name + " ";
  const app::Commands& c = v.commands;
  text +=
      numbers({double(c.frame_all), double(c.frame_selection), c.camera ? double(*c.camera) : -1,
               double(v.edits.variant), double(c.free_camera), double(c.screenshot), double(c.toggle_video),
               double(c.close), double(c.undo), double(c.redo), double(c.save_overlay),
               double(c.save_as.has_value()), double(c.export_glb), c.add ? double(*c.add) : -1,
               double(c.duplicate), double(c.list_assets), double(c.focus_on_point)});
  text +=
      numbers({double(v.shows_grid), double(v.shows_frusta), double(v.measures), double(v.measured.size())});
  text +=
      c.open.value_or("").string() + " " + c.export_csv.value_or("") + " " + c.add_asset.value_or("") + " ";
  text += v.save_path + " " + c.remove_addition.value_or("") + " ";
  text += v.screenshot_size.fixed_px + " " + numbers({double(v.screenshot_size.kind)});
  for (const std::string& call : world.timeline.calls) text += call + " ";
  return text + world.clipboard + layout_text(world.gui.layout());
}

// Hash of the panels' vertices, without mouse hover.
uint64_t panel_hash(GuiWorld& world) {
  world.frame({gui::MouseLeft{}});
  const ImDrawData& data = world.settle();
  uint64_t hash = 1469598103934665603ull;
  for (int l = 0; l < data.CmdListsCount; ++l) {
    const auto* bytes = reinterpret_cast<const uint8_t*>(data.CmdLists[l]->VtxBuffer.Data);
    const size_t count = size_t(data.CmdLists[l]->VtxBuffer.Size) * sizeof(ImDrawVert);
    for (size_t i = 0; i < count; ++i) hash = (hash ^ bytes[i]) * 1099511628211ull;
  }
  return hash;
}

// True for controls that only change the appearance of their panel.
bool changes_panel_only(const Control& control) {
  if (control.panel == "Plots" || control.panel == "Frame" || control.panel == "Lights" ||
      control.panel == "Materials")
    return control.kind == Kind::row || control.name == "Of the selection" || control.name == "Pause##plots";
  return (control.panel == "Scene" &&
          (control.kind == Kind::text || control.name == "Open" || control.name == "Close")) ||
         control.name == "Clear##log";
}

class GuiPanels : public ::testing::Test {
 protected:
  void SetUp() override { renew(); }

  // Resets the panels, opens all of them, and selects these rows of lights and materials.
  void renew(size_t light = SIZE_MAX, size_t material = SIZE_MAX) {
    world_.emplace();
    world().display_px = {1600, 3000};  // room for everything
    world().gui.note_controls(true);
    reset();
    for (const char* title : {"Lights", "Materials", "Plots", "Edit"})
      click_at(center_of(find("", title, Kind::header)));
    choose_row("Lights", light);
    choose_row("Materials", material);
    choose_row("Plots", 1);  // 0: the plot
    reset();
  }
  GuiWorld& world() { return *world_; }
  std::vector<Control> rows_of(const std::string& panel) {
    std::vector<Control> rows;
    for (const Control& control : world().gui.controls()) {
      if (control.panel == panel && control.kind == Kind::row) rows.push_back(control);
    }
    return rows;
  }
  void choose_row(const char* panel, size_t number) {
    const std::vector<Control> rows = rows_of(panel);
    if (number < rows.size()) click_at(center_of(rows[number]));
  }

  // Resets the user's requests, so that every control can have an effect.
  void reset() {
    app::ViewState& view_state = world().view_state;
    view_state = {};
    view_state.draw.post.lens = {2.8f, 2};
    view_state.picked_point = app::SurfacePoint{2, {0.1f, 0, 0}};
    if (has_paths_) view_state.draw.path = view_state.paths;
    view_state.selected = 2;
    view_state.edits.hidden = {1};
    view_state.followed = 1;
    view_state.help = true;
    view_state.edits.joints[0] = {0.5};
    view_state.measures = true;
    view_state.screenshot_size.kind = app::ScreenshotSize::Kind::fixed;
    view_state.measured = {{2, {0.1f, 0, 0}}, {1, {0, 0.2f, 0}}};
    view_state.save_path = "other.json";
    view_state.streams[0x52] = {true, 100'000'000};
    for (const uint32_t node : {3, 4, 5}) view_state.edits.lights[node] = world().scene.lights[node - 3];
    for (uint32_t m = 0; m < world().scene.materials.size(); ++m)
      view_state.edits.materials[m] = scene::factors_of(world().scene.materials[m]);
    world().timeline.calls.clear();
    world().clipboard.clear();
    world().settle();
  }

  static glm::vec2 center_of(const Control& control) { return (control.rect.low + control.rect.high) * 0.5f; }
  static glm::vec2 within(const Control& control, float x, float y) {
    return control.rect.low + (control.rect.high - control.rect.low) * glm::vec2(x, y);
  }

  const Control& find(const std::string& panel, const std::string& name, Kind kind) {
    for (const Control& control : world().gui.controls()) {
      if ((panel.empty() || control.panel == panel) && control.name == name && control.kind == kind)
        return control;
    }
    ADD_FAILURE() << panel << "/" << name << " is not there";
    static const Control kNothing;
    return kNothing;
  }

  void press(glm::vec2 at) {
    world().frame({gui::MouseMoved{at}});
    world().frame({gui::MouseButton{gui::Button::left, true}});
  }
  void release() {
    world().frame({gui::MouseButton{gui::Button::left, false}});
    world().frame();
  }
  void click_at(glm::vec2 at) {
    press(at);
    release();
    world().settle();
  }
  void close_popups() {
    world().frame({gui::KeyChanged{gui::Key::escape, true}});
    world().frame({gui::KeyChanged{gui::Key::escape, false}});
    click_at({world().display_px.x / 2, 40});  // the image
  }

  // Operates a control. Returns the names of its options without effect; empty if all is well.
  std::string drive(const Control& control) {
    const std::string before = settings_of(world());
    switch (control.kind) {
      case Kind::button:
      case Kind::check:
      case Kind::row:
      case Kind::header: {
        // Selects another material first: selecting the selected one has no effect.
        if (control.panel == "Materials" && control.kind == Kind::row)
          choose_row("Materials", center_of(rows_of("Materials")[0]) == center_of(control) ? 1 : 0);
        const uint64_t hash_before = panel_hash(world());
        click_at(center_of(control));
        const bool acted = settings_of(world()) != before;
        if (acted || (changes_panel_only(control) && panel_hash(world()) != hash_before)) return "";
        return control.name;
      }
      case Kind::text: {
        const uint64_t hash_before = panel_hash(world());
        click_at(center_of(control));
        EXPECT_TRUE(world().gui.wants_keyboard()) << control.name;
        world().frame({gui::Text{U'h'}, gui::Text{U'a'}, gui::Text{U'n'}});
        world().settle();
        const bool found_less = panel_hash(world()) != hash_before;
        for (int i = 0; i < 3; ++i) {
          world().frame({gui::KeyChanged{gui::Key::backspace, true}});
          world().frame({gui::KeyChanged{gui::Key::backspace, false}});
        }
        close_popups();
        EXPECT_FALSE(world().gui.wants_keyboard());
        return found_less ? "" : control.name;
      }
      case Kind::slider: {
        bool acted = false;
        for (const float where : {0.3f, 0.8f}) {
          press(within(control, where, 0.5f));
          world().settle();
          acted |= settings_of(world()) != before;
          release();
        }
        return acted ? "" : control.name;
      }
      case Kind::number:
      case Kind::edge: {
        press(center_of(control));
        world().frame({gui::MouseMoved{center_of(control) + glm::vec2(-25, -25)}});
        world().frame();
        release();
        return settings_of(world()) != before ? "" : control.name;
      }
      case Kind::choice:
        return drive_choice(control);
      case Kind::color: {
        click_at(center_of(control));
        const Control picker = find(control.panel, control.name + "/picker", Kind::color);
        press(within(picker, 0.35f, 0.3f));
        world().settle();
        const bool acted = settings_of(world()) != before;
        release();
        close_popups();
        return acted ? "" : control.name;
      }
    }
    return control.name;
  }

  std::string drive_choice(const Control& control) {
    std::string without_effect;
    int unchanged = 0;
    std::set<std::string> tried;
    for (bool more = true; more;) {
      more = false;
      reset();
      const std::string before = settings_of(world());
      click_at(center_of(control));
      for (const Control& item : world().gui.controls()) {
        if (item.panel != control.panel || item.name.rfind(control.name + "/", 0) != 0) continue;
        if (!tried.insert(item.name).second) continue;
        more = true;
        const std::string name = item.name;
        click_at(center_of(item));
        if (settings_of(world()) == before) {
          ++unchanged;
          without_effect += name + " ";
        }
        break;
      }
      close_popups();
    }
    EXPECT_GT(tried.size(), 1u) << control.name;
    return unchanged > 1 ? without_effect : "";  // one option is selected already
  }

  // Operates all controls of a panel, or of all panels. Returns their number.
  size_t drive_all(const std::string& panel, size_t light = SIZE_MAX, size_t material = SIZE_MAX) {
    renew(light, material);
    size_t count = 0;
    const std::vector<Control> all = world().gui.controls();
    for (const Control& control : all) {
      if (!panel.empty() && control.panel != panel) continue;
      // Clears the selection: selecting the selected row would change nothing.
      if (control.panel == "Scene" && control.kind == Kind::row) world().view_state.selected = scene::kNone;
      world().settle();
      if (has_paths_ && control.panel == "Render" && !control.enabled) continue;  // of the raster
      EXPECT_TRUE(control.enabled) << control.panel << "/" << control.name << " cannot be used here";
      EXPECT_EQ(drive(control), "") << control.panel << "/" << control.name << " changes nothing";
      ++count;
      const bool moved_others = control.kind == Kind::header || control.kind == Kind::edge ||
                                control.name.starts_with("Fold ") || changes_panel_only(control);
      if (moved_others) {
        renew(light, material);
      } else {
        reset();
      }
    }
    return count;
  }

  std::optional<GuiWorld> world_;
  bool has_paths_ = true;  // of later reset()s
};

TEST_F(GuiPanels, EveryControlDoesSomething) {
  size_t driven = drive_all("");
  // Lights and materials show the controls of the selected row only.
  ASSERT_EQ(rows_of("Lights").size(), 3u);
  ASSERT_EQ(rows_of("Materials").size(), 3u);
  for (size_t i = 0; i < 3; ++i) driven += drive_all("Lights", i) + drive_all("Materials", SIZE_MAX, i);
  has_paths_ = false;
  driven += drive_all("Render");
  EXPECT_GT(driven, 140u);
}

TEST_F(GuiPanels, PathsDisableSettingsOfTheRaster) {
  const auto disabled = [this] {
    std::set<std::string> names;
    for (const Control& control : world().gui.controls())
      if (control.panel == "Render" && !control.enabled) names.insert(control.name);
    return names;
  };
  EXPECT_EQ(disabled(), (std::set<std::string>{"Ambient occlusion", "Culling", "Diffuse bounce", "FXAA",
                                               "Level of detail", "Raster path", "Rays everywhere",
                                               "Reflections by rays", "Refraction", "Samples", "Shadows"}));
  has_paths_ = false;
  reset();
  EXPECT_EQ(disabled(), std::set<std::string>());
}

// Rows of the table that windows may set.
TEST_F(GuiPanels, RenderPanelHasAllSettings) {
  std::set<std::string> shown;
  for (const bool has_paths : {true, false}) {
    has_paths_ = has_paths;
    for (const bool has_zenith : {true, false}) {
      reset();
      if (has_zenith) world().view_state.draw.background.zenith = glm::vec3(0.5f);
      settings::DrawSettings& draw = world().view_state.draw;
      // Rows that belong to others are shown with those.
      draw.lamps.count = 2;
      draw.post.optics = {.mask_radius = 1, .fog = 0.1f, .drops = 0.1f, .full_well = 1000};
      world().settle();
      for (const Control& control : world().gui.controls())
        if (control.panel == "Render") shown.insert(control.name);
    }
  }
  for (const settings::DrawSetting& row : settings::draw_setting_table()) {
    for (const settings::SettingControl& control : row.controls)
      EXPECT_EQ(shown.count(control.label), row.users & settings::kByWindow ? 1u : 0u) << control.label;
  }
}

// A row needs no code of the panel: one of each kind, with another label.
TEST(SettingRows, NewRowsAreShown) {
  ImGui::CreateContext();
  ImGui::GetIO().DisplaySize = {400, 400};
  ImGui::GetIO().IniFilename = nullptr;
  ImGui::GetIO().Fonts->Build();
  ImGui::NewFrame();
  gui::Ui ui;
  ui.notes_controls = true;
  ui.begin_frame(1);
  settings::DrawSettings draw;
  for (const char* name : {"fxaa", "tone-map", "saturation", "background"}) {
    settings::DrawSetting row = settings::draw_setting(name);
    for (settings::SettingControl& control : row.controls) control.label = name;
    gui::draw_setting_row(ui, row, draw);
    row.users = settings::kByCommandLine;
    gui::draw_setting_row(ui, row, draw);
  }
  std::multiset<std::pair<std::string, Kind>> shown;
  for (const Control& control : ui.controls) shown.emplace(control.name, control.kind);
  ImGui::EndFrame();
  ImGui::DestroyContext();
  EXPECT_EQ(shown, (std::multiset<std::pair<std::string, Kind>>{{"fxaa", Kind::check},
                                                                {"tone-map", Kind::choice},
                                                                {"saturation", Kind::slider},
                                                                {"background", Kind::check},
                                                                {"background", Kind::check},
                                                                {"background", Kind::color}}));
}

TEST_F(GuiPanels, MaterialsFollowSelection) {
  const auto shows_alpha_cutoff = [this] {  // of "leaf" alone
    return std::ranges::any_of(world().gui.controls(), [](const Control& control) {
      return control.panel == "Materials" && control.name == "Alpha cutoff";
    });
  };
  world().view_state.selected = 0;
  world().settle();
  EXPECT_FALSE(shows_alpha_cutoff());
  world().view_state.selected = 1;
  world().settle();
  EXPECT_TRUE(shows_alpha_cutoff());
  choose_row("Materials", 0);
  EXPECT_FALSE(shows_alpha_cutoff()) << "chosen by the user";
}

TEST_F(GuiPanels, OpenedListOfFilesIsNew) {
  click_at(center_of(find("Edit", "Add file", Kind::choice)));
  EXPECT_TRUE(world().view_state.commands.list_assets);
  world().view_state.commands.list_assets = false;
  world().settle();
  EXPECT_FALSE(world().view_state.commands.list_assets) << "once for each opening";
}

TEST_F(GuiPanels, UniformScaleKeepsTheRatio) {
  world().view_state.selected = 0;
  const auto drag_y = [this] {
    const Control number = find("Edit", "Scale y", Kind::number);
    press(center_of(number));
    world().frame({gui::MouseMoved{center_of(number) + glm::vec2(30, 0)}});
    world().frame();
    release();
    return world().view_state.edits.transforms.at(0).scale;
  };
  reset();
  world().view_state.selected = 0;
  world().settle();
  const glm::vec3 single = drag_y();
  EXPECT_EQ(single.x, 1);
  EXPECT_GT(single.y, 1.1f);
  world().view_state.edits.transforms.clear();
  world().view_state.scale_is_uniform = true;
  for (int i = 0; i < 60; ++i) world().frame();  // no double click
  const glm::vec3 all = drag_y();
  EXPECT_GT(all.y, 1.1f);
  EXPECT_NEAR(all.x, all.y, 1e-4f);
  EXPECT_NEAR(all.z, all.y, 1e-4f);
}

TEST_F(GuiPanels, DrivenJointsHaveNoSlider) {
  std::vector<std::string> names;
  for (const Control& control : world().gui.controls())
    if (control.panel == "Joints" && control.kind == Kind::slider) names.push_back(control.name);
  EXPECT_EQ(names, (std::vector<std::string>{"lift", "swing"}));
  press(within(find("Joints", "swing", Kind::slider), 0.99f, 0.5f));
  world().settle();
  release();
  EXPECT_EQ(world().view_state.edits.joints.at(1), std::vector<double>{2}) << "the limit, in radians";
}

TEST_F(GuiPanels, RecoveredEditsAreAppliedOrDiscarded) {
  for (const auto& [button, applies] :
       {std::pair("Apply##recovery", true), std::pair("Discard##recovery", false)}) {
    world().editing.recovered = "3 edits of an earlier run were not saved";
    world().settle();
    click_at(center_of(find("Recovery", button, Kind::button)));
    EXPECT_EQ(world().view_state.commands.recover, applies);
    world().view_state.commands.recover.reset();
    world().editing.recovered.clear();
    world().settle();
    EXPECT_TRUE(std::ranges::none_of(world().gui.controls(),
                                     [](const Control& control) { return control.panel == "Recovery"; }));
  }
}

TEST_F(GuiPanels, NothingElseReactsToMouse) {
  std::set<std::string> strangers;
  for (float y = 3; y < world().display_px.y; y += 9) {
    for (float x = 3; x < world().display_px.x; x += 21) {
      if (x > 420 && x < 1180 && y < 2600) continue;  // the image
      world().frame({gui::MouseMoved{{x, y}}});
      if (ImGui::GetCurrentContext()->HoveredId == 0) continue;  // GetHoveredID() includes the last frame's
      bool known = false;
      for (const Control& control : world().gui.controls()) {
        known |= x >= control.rect.low.x - 1 && x <= control.rect.high.x + 1 && y >= control.rect.low.y - 3 &&
                 y <= control.rect.high.y + 3;
      }
      if (!known) strangers.insert(std::to_string(int(x)) + ", " + std::to_string(int(y)));
    }
  }
  std::string places;
  for (const std::string& place : strangers) places += place + "; ";
  EXPECT_EQ(places, "") << "what is there reacts, and is no control of ours";
}

TEST_F(GuiPanels, ImageMouseIsIgnored) {
  world().display_px = {1280, 720};
  world().view_state.help = false;
  world().settle();
  world().frame({gui::MouseMoved{{640, 200}}});
  world().frame();
  EXPECT_FALSE(world().gui.wants_mouse());
  press({640, 200});
  world().frame({gui::MouseMoved{{100, 200}}});  // a drag that started on the image belongs to the image
  world().frame();
  EXPECT_FALSE(world().gui.wants_mouse());
  release();
  world().frame({gui::MouseMoved{{100, 201}}});
  world().frame();
  EXPECT_TRUE(world().gui.wants_mouse());
  EXPECT_FALSE(world().gui.wants_keyboard());
  const gui::Rect image = world().gui.image_rect();
  EXPECT_GT(image.high.x - image.low.x, 400);
  EXPECT_GT(image.high.y - image.low.y, 300);

  world().view_state.gui = false;
  const ImDrawData& nothing = world().frame();
  world().frame();
  EXPECT_EQ(nothing.TotalVtxCount, 0);
  EXPECT_FALSE(world().gui.wants_mouse());
}

// A key is used by a widget or by the view, never by both.
TEST_F(GuiPanels, OpenListOwnsKeys) {
  const auto tap = [&](gui::Key key) {
    world().frame({gui::KeyChanged{key, true}, gui::KeyChanged{key, false}});
    const std::vector<bool> uses = world().gui.key_uses();
    EXPECT_FALSE(uses.empty());
    world().settle();
    return !uses.empty() && uses.front();
  };
  EXPECT_FALSE(tap(gui::Key::escape));
  uint32_t lists = 0;
  const std::vector<Control> controls = world().gui.controls();
  for (const Control& control : controls) {
    if (control.kind != Kind::choice && control.kind != Kind::color) continue;
    const Control shown = find(control.panel, control.name, control.kind);
    click_at(center_of(shown));
    if (!world().gui.wants_keyboard()) continue;
    EXPECT_TRUE(tap(gui::letter('h'))) << control.name;
    EXPECT_TRUE(world().gui.wants_keyboard()) << control.name;
    EXPECT_TRUE(tap(gui::Key::escape)) << control.name;
    EXPECT_FALSE(world().gui.wants_keyboard()) << control.name << ": Escape closes the list";
    EXPECT_FALSE(tap(gui::Key::escape)) << control.name;
    ++lists;
  }
  EXPECT_GT(lists, 3u);
}

// A slow image gets the click into the field, and what is typed, at once.
TEST_F(GuiPanels, TextFieldOwnsKeysAfterClick) {
  const Control search = find("Scene", "Search", Kind::text);
  const gui::HeldKeys control{.ctrl = true};
  const auto type = [](gui::Key key, gui::HeldKeys held = {}) {
    return std::vector<gui::Event>{gui::KeyChanged{key, true, false, held},
                                   gui::KeyChanged{key, false, false, held}};
  };
  std::vector<gui::Event> events{gui::MouseMoved{center_of(search)},
                                 gui::MouseButton{gui::Button::left, true},
                                 gui::MouseButton{gui::Button::left, false}};
  const auto append = [&](const std::vector<gui::Event>& more) {
    events.insert(events.end(), more.begin(), more.end());
  };
  append(type(gui::letter('h')));
  events.emplace_back(gui::Text{U'h'});
  append(type(gui::letter('a')));
  events.emplace_back(gui::Text{U'a'});
  append(type(gui::letter('a'), control));  // selects all of the text
  append(type(gui::Key::backspace));
  std::vector<bool> uses;
  world().frame(events);
  for (int i = 0; i < 20; ++i) {
    const std::vector<bool> now = world().gui.key_uses();
    uses.insert(uses.end(), now.begin(), now.end());
    world().frame();
  }
  ASSERT_EQ(uses.size(), 8u);
  for (size_t i = 0; i < uses.size(); i += 2) EXPECT_TRUE(uses[i]) << i;
  EXPECT_EQ(ImGui::GetInputTextState(ImGui::GetActiveID())->CurLenW, 0);
  close_popups();
}

TEST_F(GuiPanels, ClickBetweenFramesCounts) {
  const Control screenshot = find("Render", "Screenshot", Kind::button);
  world().frame({gui::MouseMoved{center_of(screenshot)}, gui::MouseButton{gui::Button::left, true},
                 gui::MouseButton{gui::Button::left, false}, gui::MouseMoved{{700, 10}}});
  world().settle();
  EXPECT_TRUE(world().view_state.commands.screenshot);
}

TEST_F(GuiPanels, SizesFollowScaleOfDisplay) {
  const Control once = find("Render", "Screenshot", Kind::button);
  const uint64_t fonts = world().gui.fonts_number();
  world().scale = 2;
  world().display_px *= 2;
  world().settle();
  EXPECT_GT(world().gui.fonts_number(), fonts);
  const Control twice = find("Render", "Screenshot", Kind::button);
  EXPECT_NEAR(twice.rect.high.y - twice.rect.low.y, 2 * (once.rect.high.y - once.rect.low.y), 3);
}

scene::Scene large_scene(uint32_t nodes) {
  scene::Scene scene;
  for (uint32_t i = 0; i < nodes; ++i) {
    scene::Node node;
    node.name = "body_" + std::to_string(i);
    node.path = node.name;
    if (i > 0) node.parent = i < 1000 ? 0 : (i - 1000) % 999 + 1;
    scene.nodes.push_back(std::move(node));
  }
  return scene;
}

TEST(GuiTree, OnlyVisibleRowsAreLaidOut) {
  GuiWorld world(large_scene(100'000));
  world.display_px = {1280, 800};  // room for the rows that the search finds
  world.gui.note_controls(true);
  world.settle();
  EXPECT_GT(world.gui.tree_rows(), 3u);
  EXPECT_LT(world.gui.tree_rows(), 60u);
  // A selection outside of the panel scrolls its row into view, at any depth and distance.
  world.view_state.selected = 98'765;
  world.settle();
  const auto is_seen = [&](const std::string& name) {
    for (const Control& control : world.gui.controls()) {
      if (control.panel == "Scene" && control.name == name && control.rect.low.y > 0 &&
          control.rect.high.y < world.display_px.y)
        return true;
    }
    return false;
  };
  EXPECT_TRUE(is_seen("body_98765"));
  EXPECT_LT(world.gui.tree_rows(), 60u);
  // The search also finds one of them.
  for (const Control& control : world.gui.controls()) {
    if (control.kind != Kind::text) continue;
    const glm::vec2 at = (control.rect.low + control.rect.high) * 0.5f;
    world.frame({gui::MouseMoved{at}});
    world.frame({gui::MouseButton{gui::Button::left, true}});
    world.frame({gui::MouseButton{gui::Button::left, false}});
    break;
  }
  std::vector<gui::Event> typed;
  for (const char letter : std::string("Y_4321")) typed.push_back(gui::Text{static_cast<char32_t>(letter)});
  world.frame(typed);
  world.settle();
  EXPECT_TRUE(is_seen("body_4321"));
  EXPECT_TRUE(is_seen("body_43210"));
  EXPECT_EQ(world.gui.tree_rows(), 11u);
}

// A scene with one more object: what was open stays open.
TEST(GuiTree, AdditionKeepsTheTree) {
  scene::Scene scene = large_scene(80);  // not unfolded at the start
  scene.nodes[2].parent = 1;
  GuiWorld world(std::move(scene));
  world.display_px = {1280, 3000};
  world.gui.note_controls(true);
  world.view_state.selected = 2;
  world.settle();
  world.view_state.selected = 0;
  world.settle();
  const auto is_listed = [&](const std::string& name) {
    return std::ranges::any_of(world.gui.controls(), [&](const Control& control) {
      return control.panel == "Scene" && control.kind == Kind::row && control.name == name;
    });
  };
  ASSERT_TRUE(is_listed(world.scene.nodes[2].name));
  world.scene.nodes.push_back(world.scene.nodes[1]);
  world.scene.nodes.back().name = world.scene.nodes.back().path = "added";
  world.poses.set_scene(world.scene);
  ++world.scene_number;
  world.settle();
  EXPECT_TRUE(is_listed("added"));
  EXPECT_TRUE(is_listed(world.scene.nodes[2].name));
}

TEST(GuiTree, OnlyVisibleLinesAreLaidOut) {
  GuiWorld world;
  for (int i = 0; i < 50'000; ++i) world.facts.log.push_back({double(i), "line"});
  world.facts.log_lines = world.facts.log.size();
  EXPECT_LT(world.settle().TotalVtxCount, 40'000);
}

}  // namespace
}  // namespace fire3dv::test
