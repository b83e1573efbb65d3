// Test of panels at their limits: more streams than fit, windows of a few pixels, arbitrary names.
#include <gtest/gtest.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/gui/gui_pass.h"
#include "renderer/gui/widgets.h"
#include "tests/unit/renderer/gui/gui_world.h"

namespace fire3dv::test {
namespace {

using Kind = gui::Control::Kind;

// All panels, and a second scene whose names resemble ImGui syntax or row separators.
struct OddWorld : GuiWorld {
  explicit OddWorld(scene::Scene shown = gui_scene()) : GuiWorld(std::move(shown)) {
    gui.note_controls(true);
    settle();
    for (const char* title : {"Lights", "Materials"}) open(title);
  }
  void open(const std::string& title) {
    display_px = {1600, 3000};
    settle();
    for (const gui::Control& control : gui.controls()) {
      if (control.kind != Kind::header || control.name != title) continue;
      const glm::vec2 at = (control.rect.low + control.rect.high) * 0.5f;
      frame({gui::MouseMoved{at}, gui::MouseButton{gui::Button::left, true}});
      frame({gui::MouseButton{gui::Button::left, false}, gui::MouseLeft{}});
      break;
    }
    settle();
  }
  gui::Rect rect_of(const std::string& panel, const std::string& name) {
    for (const gui::Control& control : gui.controls()) {
      if (control.panel == panel && control.name == name && control.kind == Kind::row) return control.rect;
    }
    ADD_FAILURE() << panel << "/" << name << " is not there";
    return {};
  }
};

// Counts the glyphs (textured quads) whose centre lies in the rectangle.
size_t glyphs_in(const ImDrawData& data, const gui::Rect& rect) {
  gui::GuiTiles tiles;
  tiles.build(data, {1600, 3000});
  size_t count = 0;
  for (const gpu_types::GuiPrimitive& p : tiles.primitives()) {
    const glm::vec2 middle = (glm::vec2(p.a) + glm::vec2(p.b)) * 0.5f;
    const bool is_letter = p.a.z != p.b.z && p.a.w != p.b.w;
    const bool is_inside =
        middle.x > rect.low.x && middle.x < rect.high.x && middle.y > rect.low.y && middle.y < rect.high.y;
    count += is_letter && is_inside;
  }
  return count;
}

// The fill below a flat curve of many values covers its rectangle once: columns do not overlap.
TEST(GuiPlots, LevelCurveIsFilled) {
  OddWorld world;
  world.facts.streams.at(0).gaps_ms.assign(9, 4.0f);
  world.facts.streams.resize(1);
  const ImDrawData& data = world.settle();
  constexpr ImU32 kFillAlpha = 0x30;
  ImVec2 low{1e9f, 1e9f}, high{-1e9f, -1e9f};
  double area = 0;
  for (int list_index = 0; list_index < data.CmdListsCount; ++list_index) {
    const ImDrawList* list = data.CmdLists[list_index];
    for (const ImDrawCmd& command : list->CmdBuffer) {
      for (unsigned i = 0; i + 2 < command.ElemCount; i += 3) {
        ImDrawVert corner[3];
        bool is_fill = true;
        for (unsigned c = 0; c < 3; ++c) {
          const ImDrawIdx index = list->IdxBuffer[static_cast<int>(command.IdxOffset + i + c)];
          corner[c] = list->VtxBuffer[static_cast<int>(command.VtxOffset + index)];
          is_fill &= corner[c].col >> IM_COL32_A_SHIFT == kFillAlpha;
        }
        if (!is_fill) continue;
        const ImVec2 a = corner[0].pos, b = corner[1].pos, d = corner[2].pos;
        area += 0.5 * std::abs((b.x - a.x) * (d.y - a.y) - (b.y - a.y) * (d.x - a.x));
        for (const ImDrawVert& v : corner) {
          low = {std::min(low.x, v.pos.x), std::min(low.y, v.pos.y)};
          high = {std::max(high.x, v.pos.x), std::max(high.y, v.pos.y)};
        }
      }
    }
  }
  const double all = (high.x - low.x) * (high.y - low.y);
  ASSERT_GT(all, 500) << "no curve is there";
  EXPECT_NEAR(area / all, 1, 0.1);  // edges are anti-aliased
}

TEST(GuiLimits, ManyStreamsFit) {
  OddWorld world;
  const gui::StreamFact one = world.facts.streams.at(0);
  for (uint64_t i = 0; i < 200; ++i) {
    gui::StreamFact stream = one;
    stream.epoch = 0x1000 + i;
    stream.name += std::to_string(i);
    world.facts.streams.push_back(std::move(stream));
  }
  // In a small window, and in one with room for all: there a list has more vertices than 16-bit indices
  // count, so commands need vertex offsets.
  world.display_px = {1280, 720};
  const int corners_of_few = world.settle().TotalVtxCount;
  world.display_px = {1600, 60'000};
  const ImDrawData& data = world.settle();
  EXPECT_GT(data.TotalVtxCount, 10 * corners_of_few);
  size_t offsets = 0;
  for (int l = 0; l < data.CmdListsCount; ++l) {
    const ImDrawList& list = *data.CmdLists[l];
    for (const ImDrawCmd& command : list.CmdBuffer) {
      offsets += command.VtxOffset > 0;
      for (unsigned i = 0; i < command.ElemCount; ++i) {
        const auto at = static_cast<size_t>(list.IdxBuffer[static_cast<int>(command.IdxOffset + i)]);
        ASSERT_LT(command.VtxOffset + at, static_cast<size_t>(list.VtxBuffer.Size));
      }
    }
  }
  EXPECT_GT(offsets, 0u);
}

TEST(GuiLimits, AnyWindowSizeWorks) {
  OddWorld world;
  for (const float scale : {1.0f, 1.25f, 2.0f}) {
    world.scale = scale;
    for (float height = 1; height <= 100; height += 33) {
      for (float width = 1; width <= 200; width += scale == 1 ? 1 : 7) {
        world.display_px = {width, height};
        world.view_state.help = static_cast<int>(width) % 2 == 0;
        world.frame();
        const gui::Rect image = world.gui.image_rect();
        ASSERT_LE(image.high.x, width);
        ASSERT_LE(image.high.y, height);
      }
    }
  }
  world.display_px = {16, 200};
  world.settle();
}

TEST(GuiLimits, NanScaleIsOne) {
  OddWorld world;
  const uint64_t fonts = world.gui.fonts_number();
  for (const float scale :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    world.scale = scale;
    world.settle();
  }
  EXPECT_EQ(world.gui.fonts_number(), fonts);
}

TEST(GuiLimits, NamesStayOnOneLine) {
  scene::Scene scene = gui_scene();
  const std::string plain = "xxxxxxxx", marked = "xx##xxxx", broken = "xx\nxxx\rx";
  scene.nodes[0].name = plain;
  scene.nodes[1].name = marked;
  scene.nodes[2].name = broken;
  OddWorld world(std::move(scene));
  const ImDrawData& data = world.settle();
  const gui::Rect first = world.rect_of("Scene", plain);
  const size_t letters = glyphs_in(data, first);
  EXPECT_GE(letters, plain.size());
  EXPECT_EQ(glyphs_in(data, world.rect_of("Scene", marked)), letters);
  EXPECT_EQ(glyphs_in(data, world.rect_of("Scene", broken)), letters - 2);  // blanks have no glyph
  for (const std::string& name : {marked, broken}) {
    const gui::Rect rect = world.rect_of("Scene", name);
    EXPECT_FLOAT_EQ(rect.high.y - rect.low.y, first.high.y - first.low.y);
  }
  EXPECT_EQ(gui::one_line("a\nb\tc\x7f"
                          "d\xc3\xa9"),
            "a b c d\xc3\xa9");
}

TEST(GuiLimits, TextsBreakAtSpaces) {
  OddWorld world;
  world.frame();
  ImGui::NewFrame();
  const auto width = [](const char* text) { return ImGui::CalcTextSize(text).x + 1; };
  EXPECT_EQ(gui::wrapped("-0.26532 0.15 0.33717 m", width("-0.26532 0.15 0.33717 m")),
            "-0.26532 0.15 0.33717 m");
  EXPECT_EQ(gui::wrapped("-0.26532 0.15 0.33717 m", width("-0.26532 0.15 0.")), "-0.26532 0.15\n0.33717 m");
  EXPECT_EQ(gui::wrapped("4.6 /s   219.2 ms", width("4.6 /s   219.2")), "4.6 /s   219.2\nms");
  EXPECT_EQ(gui::wrapped("a   b c", width("a b")), "a\nb c");
  EXPECT_EQ(gui::wrapped("a b c", 1), "a\nb\nc");
  for (const char* text : {"", " ", "a ", "whole/path_without_spaces"})
    EXPECT_EQ(gui::wrapped(text, 1), text);
  ImGui::EndFrame();
}

// At a display scale of 2 the fields of a transform are below their label, side by side and equally wide.
TEST(GuiLimits, NumbersFitNarrowColumn) {
  for (const float scale : {1.0f, 2.0f}) {
    OddWorld world;
    std::vector<gui::Rect> headers;
    for (const gui::Control& control : world.gui.controls())
      if (control.name == "Edit") headers.push_back(control.rect);
    ASSERT_EQ(headers.size(), 1u);
    world.frame({gui::MouseMoved{(headers[0].low + headers[0].high) * 0.5f}});
    world.frame({gui::MouseButton{gui::Button::left, true}});
    world.frame({gui::MouseButton{gui::Button::left, false}});
    world.view_state.selected = 3;
    world.display_px = {1280, 3000};
    world.scale = scale;
    world.settle();
    std::vector<gui::Rect> fields;
    for (const gui::Control& control : world.gui.controls())
      if (control.kind == Kind::number && control.name.starts_with("Position"))
        fields.push_back(control.rect);
    ASSERT_EQ(fields.size(), 3u);
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_GE(fields[i].high.x - fields[i].low.x, 40 * scale) << "room for -00.000";
      EXPECT_EQ(fields[i].low.y, fields[0].low.y);
      if (i > 0) {
        EXPECT_GT(fields[i].low.x, fields[i - 1].high.x);
      }
    }
  }
}

TEST(GuiLimits, KeySettingsAreKept) {
  OddWorld world;
  world.view_state.camera_speed = 2.5f;
  world.settle();
  EXPECT_FLOAT_EQ(world.gui.layout().camera_speed, 2.5f);
}

}  // namespace
}  // namespace fire3dv::test
