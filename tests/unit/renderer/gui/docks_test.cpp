// Test of the docks: they tile the window, splitters and handles change the uncovered rectangle, and small
// windows and large scales cut no text.
#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>

#include <string>

#include "renderer/gui/docks.h"
#include "renderer/gui/widgets.h"
#include "tests/unit/renderer/gui/gui_world.h"

namespace fire3dv::test {
namespace {

using Kind = gui::Control::Kind;

// Number of areas at a point.
int covers(const gui::DockAreas& areas, glm::vec2 at) {
  int count = 0;
  const auto add = [&](const gui::Rect& rect) {
    count += at.x > rect.low.x && at.x < rect.high.x && at.y > rect.low.y && at.y < rect.high.y;
  };
  for (const gui::DockAreas::Area& area : {areas.left, areas.right, areas.bottom}) {
    add(area.panels);
    add(area.splitter);
  }
  add(areas.image);
  return count;
}

TEST(GuiDocks, TileTheWindow) {
  for (const float scale : {1.0f, 1.25f, 2.0f}) {
    for (int folded = 0; folded < 8; ++folded) {
      gui::Layout layout;
      for (size_t dock = 0; dock < gui::kDocks; ++dock) layout.folded[dock] = (folded >> dock & 1) != 0;
      for (const glm::vec2 size :
           {glm::vec2(1, 1), glm::vec2(2, 1), glm::vec2(9, 7), glm::vec2(64, 33), glm::vec2(640, 400)}) {
        const gui::DockAreas areas = gui::dock_areas(size, scale, layout, 150.25f * scale);
        for (float y = 0.5f; y<size.y; y += size.y> 40 ? 7 : 1) {
          for (float x = 0.5f; x < size.x; ++x)
            ASSERT_EQ(covers(areas, {x, y}), 1) << x << ", " << y << " of " << size.x << " x " << size.y;
        }
      }
    }
  }
}

struct DockWorld : GuiWorld {
  DockWorld() {
    gui.note_controls(true);
    settle();
  }
  gui::Control find(const std::string& name, Kind kind) {
    for (const gui::Control& control : gui.controls()) {
      if (control.name == name && control.kind == kind) return control;
    }
    ADD_FAILURE() << name << " is not there";
    return {};
  }
  void press(glm::vec2 at) {
    frame({gui::MouseMoved{at}});
    frame({gui::MouseButton{gui::Button::left, true}});
  }
  void release() {
    frame({gui::MouseButton{gui::Button::left, false}});
    settle();
  }
  static glm::vec2 center(const gui::Control& control) {
    return (control.rect.low + control.rect.high) * 0.5f;
  }
  void drag(const std::string& name, glm::vec2 by) {
    const glm::vec2 from = center(find(name, Kind::edge));
    press(from);
    frame({gui::MouseMoved{from + by}});
    frame();
    release();
  }
  void click(const std::string& name) {
    press(center(find(name, Kind::button)));
    release();
  }
};

TEST(GuiDocks, SplittersMoveTheUncoveredRectangle) {
  DockWorld world;
  const gui::Rect before = world.gui.image_rect();
  world.drag("edge of the left column", {31, 0});
  EXPECT_FLOAT_EQ(world.gui.image_rect().low.x, before.low.x + 31);
  world.drag("edge of the right column", {-20, 0});
  EXPECT_FLOAT_EQ(world.gui.image_rect().high.x, before.high.x - 20);
  world.drag("edge of the log", {0, -20});
  EXPECT_FLOAT_EQ(world.gui.image_rect().high.y, before.high.y - 20);
  EXPECT_FLOAT_EQ(world.gui.image_rect().low.y, 0);
}

// A slow image takes all events of a drag at once.
TEST(GuiDocks, DragBetweenFramesCounts) {
  DockWorld world;
  const float before = world.gui.image_rect().low.x;
  const glm::vec2 from = DockWorld::center(world.find("edge of the left column", Kind::edge));
  world.frame({gui::MouseMoved{from}, gui::MouseButton{gui::Button::left, true},
               gui::MouseMoved{from + glm::vec2(12, 0)}, gui::MouseMoved{from + glm::vec2(31, 0)},
               gui::MouseButton{gui::Button::left, false}, gui::MouseLeft{}});
  world.settle();
  world.settle();
  EXPECT_FLOAT_EQ(world.gui.image_rect().low.x, before + 31);
}

TEST(GuiDocks, HandlesFoldAndUnfold) {
  DockWorld world;
  const gui::Rect before = world.gui.image_rect();
  for (const char* dock : {"the left column", "the right column", "the log"})
    world.click(std::string("Fold ") + dock);
  const gui::Rect image = world.gui.image_rect();
  EXPECT_LT(image.low.x, 20);
  EXPECT_GT(image.high.x, world.display_px.x - 20);
  EXPECT_GT(image.high.y, world.display_px.y - 20);
  // The layout file has it.
  const Result<gui::Layout> kept = gui::parse_layout(layout_text(world.gui.layout()));
  ASSERT_TRUE(kept);
  for (size_t dock = 0; dock < gui::kDocks; ++dock) EXPECT_TRUE(kept->folded[dock]);
  EXPECT_FALSE(gui::parse_layout("left-dock = closed"));
  for (const char* dock : {"the left column", "the right column", "the log"})
    world.click(std::string("Unfold ") + dock);
  EXPECT_EQ(world.gui.image_rect().low, before.low);
  EXPECT_EQ(world.gui.image_rect().high, before.high);
}

TEST(GuiDocks, HiddenPanelsFreeWindow) {
  DockWorld world;
  world.view_state.gui = false;
  world.settle();
  EXPECT_EQ(world.gui.image_rect().low, glm::vec2(0));
  EXPECT_EQ(world.gui.image_rect().high, world.display_px);
}

// Names of windows whose contents are wider than they are, or higher without a scrollbar.
std::string cut_windows() {
  std::string names;
  for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows) {
    if (!window->Active || window->Hidden) continue;
    const bool is_cut = window->ScrollMax.x > 0 || (window->ScrollMax.y > 0 && !window->ScrollbarY);
    if (is_cut) names += std::string(window->Name) + " ";
  }
  return names;
}

// Number of glyphs that a left or right edge of a clip rectangle cuts.
size_t cut_glyphs(const ImDrawData& data) {
  size_t count = 0;
  for (int l = 0; l < data.CmdListsCount; ++l) {
    const ImDrawList& list = *data.CmdLists[l];
    for (const ImDrawCmd& command : list.CmdBuffer) {
      for (unsigned i = 0; i < command.ElemCount; ++i) {
        const ImDrawVert& v = list.VtxBuffer[static_cast<int>(
            command.VtxOffset + list.IdxBuffer[static_cast<int>(command.IdxOffset + i)])];
        const ImVec2 white = ImGui::GetFontTexUvWhitePixel();
        const bool is_letter = v.uv.x != white.x || v.uv.y != white.y;
        count += is_letter && (v.pos.x < command.ClipRect.x - 1.5f || v.pos.x > command.ClipRect.z + 1.5f) &&
                 v.pos.y > command.ClipRect.y && v.pos.y < command.ClipRect.w;
      }
    }
  }
  return count;
}

TEST(GuiDocks, TextFitsSmallWindows) {
  struct Case {
    glm::vec2 size_px;
    float scale;
  };
  for (const Case& each :
       {Case{{640, 400}, 1}, Case{{1280, 720}, 2}, Case{{1280, 720}, 1}, Case{{1000, 500}, 1.25f}}) {
    SCOPED_TRACE(std::to_string(each.size_px.x) + " at scale " + std::to_string(each.scale));
    DockWorld world;
    world.display_px = {1600, 3000};
    world.settle();
    for (const char* title : {"Lights", "Materials", "Plots", "Edit"}) {
      world.press(DockWorld::center(world.find(title, Kind::header)));
      world.release();
    }
    world.scene.nodes[1].name = "a_name_of_a_link_that_is_longer_than_any_column_of_a_small_window_is_wide";
    world.facts.streams[0].name = world.scene.nodes[1].name;
    world.facts.log.push_back(
        {12.5, "warning: " + world.scene.nodes[1].name + ": " + world.scene.nodes[1].name});
    world.facts.log_lines = world.facts.log.size();
    world.view_state.selected = 1;
    world.display_px = each.size_px;
    world.scale = each.scale;
    for (const bool help : {false, true}) {
      world.view_state.help = help;
      const ImDrawData& data = world.settle();
      EXPECT_EQ(cut_windows(), "") << "with help: " << help;
      EXPECT_EQ(cut_glyphs(data), 0u) << "with help: " << help;
    }
    const ImGuiWindow* const help = ImGui::FindWindowByName("help");
    ASSERT_TRUE(help);
    EXPECT_GE(help->Pos.x, 0);
    EXPECT_GE(help->Pos.y, 0);
    EXPECT_LE(help->Pos.x + help->Size.x, each.size_px.x);
    EXPECT_LE(help->Pos.y + help->Size.y, each.size_px.y);
    EXPECT_FALSE(help->ScrollbarY) << "all keys are seen at once";
    // Every control lies within the window, however far down its column scrolls.
    for (const gui::Control& control : world.gui.controls()) {
      EXPECT_GE(control.rect.low.x, 0) << control.panel << "/" << control.name;
      EXPECT_LE(control.rect.high.x, each.size_px.x) << control.panel << "/" << control.name;
    }
    const gui::Rect image = world.gui.image_rect();
    EXPECT_GE(image.high.x - image.low.x, each.size_px.x * 0.39f);
    EXPECT_GE(image.high.y - image.low.y, each.size_px.y * 0.59f);
  }
}

TEST(GuiDocks, OvertakenPosesAreNoWarning) {
  const auto warnings = [](uint64_t overtaken, uint64_t incomplete) {
    DockWorld world;
    world.facts.streams.clear();
    world.facts.links = {{"shm://a", 1, 1000, overtaken, incomplete, 0}};
    const ImDrawData& data = world.settle();
    size_t count = 0;
    for (int l = 0; l < data.CmdListsCount; ++l) {
      for (const ImDrawVert& v : data.CmdLists[l]->VtxBuffer) count += v.col == gui::theme::palette->warning;
    }
    return count;
  };
  EXPECT_EQ(warnings(5, 0), 0u);
  EXPECT_GT(warnings(5, 1), 0u);
}

}  // namespace
}  // namespace fire3dv::test
