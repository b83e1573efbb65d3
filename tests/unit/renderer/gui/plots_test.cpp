// Test of the Plots panel and of its CSV table, without a window and a GPU.
#include <gtest/gtest.h>
#include <imgui.h>

#include <cmath>
#include <cstdlib>
#include <sstream>

#include "renderer/gui/panels.h"
#include "tests/unit/renderer/gui/gui_world.h"

namespace fire3dv::test {
namespace {

using gui::Control;
using Kind = gui::Control::Kind;

class ScalarPlots : public ::testing::Test {
 protected:
  void SetUp() override {
    world.display_px = {1280, 2400};
    world.gui.note_controls(true);
    world.settle();
    click(middle(find("Plots", Kind::header)));
  }
  const Control& find(const std::string& name, Kind kind) {
    for (const Control& control : world.gui.controls())
      if (control.name == name && control.kind == kind) return control;
    ADD_FAILURE() << name << " is not there";
    static const Control kNothing;
    return kNothing;
  }
  static glm::vec2 middle(const Control& control) { return (control.rect.low + control.rect.high) * 0.5f; }
  void click(glm::vec2 at) {
    world.frame({gui::MouseMoved{at}});
    world.frame({gui::MouseButton{gui::Button::left, true}});
    world.frame({gui::MouseButton{gui::Button::left, false}});
    world.settle();
  }
  void click_row(const std::string& name) { click(middle(find(name, Kind::row))); }
  void click_button(const std::string& name) { click(middle(find(name, Kind::button))); }
  // Place in the plot; shares of its width and height, from the upper left.
  glm::vec2 in_plot(float x, float y) {
    const Control plot = find("plot", Kind::row);
    return plot.rect.low + (plot.rect.high - plot.rect.low) * glm::vec2(x, y);
  }

  // Lines of the exported table.
  std::vector<std::string> exported() {
    click_button("Export CSV");
    std::vector<std::string> lines;
    if (!world.view_state.commands.export_csv) return lines;
    std::istringstream text(*std::exchange(world.view_state.commands.export_csv, std::nullopt));
    for (std::string line; std::getline(text, line);) lines.push_back(line.substr(0, line.size() - 1));
    return lines;
  }
  static double first_number(const std::string& line) { return std::strtod(line.c_str(), nullptr); }

  // Vertices of this colour within the plot.
  std::vector<glm::vec2> vertices(ImU32 color) {
    world.frame({gui::MouseLeft{}});
    const ImDrawData& data = world.settle();
    const Control plot = find("plot", Kind::row);
    std::vector<glm::vec2> result;
    for (int l = 0; l < data.CmdListsCount; ++l)
      for (const ImDrawVert& vertex : data.CmdLists[l]->VtxBuffer) {
        const glm::vec2 at{vertex.pos.x, vertex.pos.y};
        const bool is_inside = at.x > plot.rect.low.x - 3 && at.x < plot.rect.high.x + 3 &&
                               at.y > plot.rect.low.y - 3 && at.y < plot.rect.high.y + 3;
        if (vertex.col == color && is_inside) result.push_back(at);
      }
    return result;
  }

  GuiWorld world;
};

TEST_F(ScalarPlots, CurveGoesThroughItsSamples) {
  EXPECT_TRUE(vertices(gui::theme::palette->accent).empty()) << "nothing is chosen yet";
  click_row("arm/elbow");  // rises evenly from 0 to 1
  const std::vector<glm::vec2> curve = vertices(gui::theme::palette->accent);
  ASSERT_GT(curve.size(), 50u);
  const glm::vec2 low = in_plot(0, 0), high = in_plot(1, 1);
  // A tenth of half of the values is left free above and below.
  const float margin = (high.y - low.y) * 0.05f / 1.1f;
  float sum = 0;
  for (const glm::vec2& at : curve) {
    const float share = (at.x - low.x) / (high.x - low.x);
    const float off = at.y - (high.y - margin - share * (high.y - low.y - 2 * margin));
    EXPECT_LT(std::abs(off), 4) << at.x << ": farther off than the edges of the line";
    sum += off;
  }
  EXPECT_NEAR(sum / static_cast<float>(curve.size()), 0, 0.1);
  EXPECT_NEAR(curve.front().x, low.x, 3);
  EXPECT_NEAR(curve.back().x, high.x, 3);
  click_row("arm/shoulder");
  EXPECT_FALSE(vertices(gui::theme::palette->warning).empty()) << "the second has another colour";
  click_row("arm/elbow");
  EXPECT_TRUE(vertices(gui::theme::palette->accent).empty());
  EXPECT_FALSE(vertices(gui::theme::palette->warning).empty()) << "and keeps it";
}

TEST_F(ScalarPlots, WheelOverPlotKeepsColumn) {
  world.display_px = {1280, 360};
  world.settle();
  click(middle(find("Frame", Kind::header)));
  click(middle(find("Streams", Kind::header)));
  click(middle(find("Render", Kind::header)));
  const float before = find("plot", Kind::row).rect.low.y;
  ASSERT_LT(before, 300);
  world.frame({gui::MouseMoved{in_plot(0.5f, 0.2f)}});
  world.settle();
  for (int i = 0; i < 4; ++i) world.frame({gui::MouseWheel{{0, -1}}});
  world.settle();
  EXPECT_EQ(find("plot", Kind::row).rect.low.y, before);
  world.frame({gui::MouseMoved{middle(find("Lights", Kind::header))}});
  world.settle();
  for (int i = 0; i < 4; ++i) world.frame({gui::MouseWheel{{0, -1}}});
  world.settle();
  EXPECT_LT(find("plot", Kind::row).rect.low.y, before) << "the column does scroll";
}

TEST_F(ScalarPlots, MissingValuesAreGaps) {
  world.scalars("gap", {{"x"}, {"m"}});
  for (int64_t step = 0; step <= 10; ++step)
    world.sample("gap", step * 1'000'000, {step == 4 || step == 5 ? NAN : 1.0});
  world.settle();
  click_row("gap/x");
  const glm::vec2 low = in_plot(0.32f, 0), high = in_plot(0.58f, 1);
  for (const glm::vec2& at : vertices(gui::theme::palette->accent))
    EXPECT_TRUE(at.x < low.x || at.x > high.x) << at.x;
}

TEST_F(ScalarPlots, ExportsTheShownRange) {
  click_row("arm/shoulder");
  std::vector<std::string> lines = exported();
  ASSERT_EQ(lines.size(), 102u);
  EXPECT_EQ(lines[0], "sim_time_s,\"arm/shoulder [rad]\"");
  EXPECT_EQ(lines[1], "0.000000000,0");
  EXPECT_EQ(lines[101].substr(0, 12), "1.000000000,");
  EXPECT_EQ(std::strtod(lines[101].c_str() + 12, nullptr), std::sin(0.1 * 100));

  // The wheel zooms around the mouse: half of the range, and its middle stays.
  world.frame({gui::MouseMoved{in_plot(0.5f, 0.5f)}});
  world.frame({gui::MouseWheel{{0, 3.1063f}}});  // 0.8 ^ 3.1063 = 0.5
  lines = exported();
  ASSERT_NEAR(static_cast<double>(lines.size()), 52, 2);
  EXPECT_NEAR(first_number(lines[1]), 0.25, 0.011);
  EXPECT_NEAR(first_number(lines.back()), 0.75, 0.011);

  // Dragging to the left shows later times.
  const glm::vec2 begin = in_plot(0.6f, 0.5f), end = in_plot(0.2f, 0.5f);
  world.frame({gui::MouseMoved{begin}});
  world.frame({gui::MouseButton{gui::Button::left, true}});
  for (int i = 1; i <= 8; ++i)
    world.frame({gui::MouseMoved{begin + (end - begin) * (static_cast<float>(i) / 8)}});
  world.frame({gui::MouseButton{gui::Button::left, false}});
  lines = exported();
  EXPECT_NEAR(first_number(lines[1]), 0.45, 0.02);
  EXPECT_NEAR(first_number(lines.back()), 0.95, 0.02);

  click_button("Pause##plots");  // ends the user's range
  EXPECT_EQ(exported().size(), 102u);
}

TEST_F(ScalarPlots, PauseHoldsRange) {
  click_row("arm/elbow");
  click_button("Pause##plots");
  world.sample("arm", 2'000'000'000, {0, 5});
  EXPECT_EQ(first_number(exported().back()), 1.0);
  click_button("Pause##plots");
  EXPECT_EQ(first_number(exported().back()), 2.0);
  world.sample("arm", 500'000'000, {0, 7});  // the simulation was reset
  const std::vector<std::string> lines = exported();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[1], "0.500000000,7");
}

TEST_F(ScalarPlots, ThousandsOfScalarsAreSearched) {
  wire::Scalars many;
  for (int i = 0; i < 4000; ++i) {
    many.names.push_back("joint " + std::to_string(i));
    many.units.push_back("rad");
  }
  world.scalars("many", many);
  world.sample("many", 0, std::vector<double>(4000, 0.5));
  world.settle();
  const auto rows = [&] {
    size_t count = 0;
    for (const Control& control : world.gui.controls())
      count += control.kind == Kind::row && control.name.find("joint") != std::string::npos;
    return count;
  };
  EXPECT_LT(rows(), 30u) << "only visible rows are laid out";
  click(middle(find("search", Kind::text)));
  for (const char32_t c : {U'3', U'9', U'8', U'7'}) world.frame({gui::Text{c}});
  world.settle();
  EXPECT_EQ(rows(), 1u);
  click_row("many/joint 3987");
  EXPECT_EQ(exported()[0], "sim_time_s,\"many/joint 3987 [rad]\"");
}

TEST(ScalarTable, MergesTimesAndQuotesNames) {
  stream::ScalarHistory history;
  uint64_t version = 0;
  const auto declare = [&](const std::string& group, wire::Scalars scalars) {
    history.apply({7, ++version, group, wire::Property::scalars, std::move(scalars)});
    return version;
  };
  const uint64_t a = declare("a", {{"say \"x\", y"}, {""}}), b = declare("b", {{"p", "q"}, {"N m", ""}});
  const auto sample = [&](uint64_t declared, const std::string& group, int64_t ns,
                          std::vector<double> values) {
    history.apply({7, 99, group, wire::Property::scalar_values, wire::ScalarValues{declared, ns, values}});
  };
  sample(a, "a", -1'500'000'000, {1});
  sample(a, "a", 0, {0.1});
  sample(a, "a", 5, {NAN});
  sample(b, "b", 0, {1, 1e300});
  sample(b, "b", 7, {2, -2});
  const gui::ScalarColumn columns[] = {{"a/say \"x\", y", &history.groups().at("a"), 0},
                                       {"b/p", &history.groups().at("b"), 0},
                                       {"b/q", &history.groups().at("b"), 1}};
  EXPECT_EQ(gui::csv_text(columns, INT64_MIN, INT64_MAX),
            "sim_time_s,\"a/say \"\"x\"\", y\",\"b/p [N m]\",\"b/q\"\r\n"
            "-1.500000000,1,,\r\n"
            "0.000000000,0.1,1,1e+300\r\n"
            "0.000000005,,,\r\n"
            "0.000000007,,2,-2\r\n");
  EXPECT_EQ(gui::csv_text({columns, 1}, 1, 4), "sim_time_s,\"a/say \"\"x\"\", y\"\r\n");
  // No formula for spreadsheets.
  for (const char* name : {"=1+1", "+1", "-1", "@SUM(1)", "\t=1"}) {
    const gui::ScalarColumn formula[] = {{name, &history.groups().at("a"), 0}};
    EXPECT_EQ(gui::csv_text(formula, 1, 4), "sim_time_s,\"'" + std::string(name) + "\"\r\n");
  }
}

// Once for all runs: the layout file has it.
TEST(GuiPlots, FirstScalarsUnfoldPanel) {
  GuiWorld world;
  gui::Input input;
  input.display_px = {1280, 720};
  const auto has_plot = [&](const gui::Layout& layout, const state::PoseState& poses) {
    gui::Gui panels(layout);
    for (int i = 0; i < 3; ++i) panels.frame(input, world.facts, {world.scene, poses}, world.view_state);
    return panels.layout().is_open(gui::Panel::plots);
  };
  EXPECT_FALSE(has_plot({}, state::PoseState(world.scene)));
  EXPECT_TRUE(has_plot({}, world.poses));
  gui::Layout folded_again;
  folded_again.has_plotted = true;
  EXPECT_FALSE(has_plot(folded_again, world.poses));
}

TEST(GuiNumbers, AreNeverMinusZero) {
  EXPECT_EQ(gui::without_minus_zero(-0.04f, "%.1f"), 0);
  EXPECT_FALSE(std::signbit(gui::without_minus_zero(-0.0f, "%.3f")));
  EXPECT_EQ(gui::without_minus_zero(-0.06f, "%.1f"), -0.06f);
  EXPECT_EQ(gui::without_minus_zero(-0.04f, "%.3f"), -0.04f);
  EXPECT_EQ(gui::without_minus_zero(0.04f, "%.1f"), 0.04f);
}

}  // namespace
}  // namespace fire3dv::test
