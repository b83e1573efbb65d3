// Render test of the ImGui pass against a CPU rasterizer: each pixel is the blend of ImGui's triangles in
// their order, and pixels without panels stay unchanged.
#include <gtest/gtest.h>
#include <imgui.h>

#include <cmath>

#include "renderer/gui/gui_pass.h"
#include "tests/render/support/render_bench.h"
#include "tests/unit/renderer/gui/gui_world.h"

namespace fire3dv::test {
namespace {

constexpr uint32_t kWidth = 700, kHeight = 420;

class GuiPicture : public ValidationIsSilent {};

// The image without and with panels.
struct Pictures {
  sinks::FrameImage bare, with_panels;
};

class Screen {
 public:
  explicit Screen(const scene::Scene& scene, VkExtent2D extent = {kWidth, kHeight})
      : poses_(scene),
        frames_(device()),
        renderer_(device(), {}),
        readback_(device()),
        pass_(device()),
        scene_(scene),
        extent_(extent) {
    renderer_.set_scene(scene);
  }
  sinks::FrameImage draw(const ImDrawData* panels, const ImFontAtlas* fonts, uint64_t fonts_number) {
    const Result<passes::PreparedFrame> prepared = renderer_.prepare({.extent = extent_});
    if (!prepared) {
      ADD_FAILURE() << prepared.error().message;
      return {};
    }
    gpu::Recorder& recorder = frames_.begin();
    renderer_.record(*prepared, recorder, frames_.staging(), poses_,
                     first_camera_view(scene_, poses_, extent_));
    if (panels) pass_.record(recorder, frames_.staging(), renderer_.image(), *panels, *fonts, fonts_number);
    readback_.record(recorder, renderer_.image(), 0);
    readback_.submitted(frames_.submit());
    sinks::FrameImage image;
    readback_.drain([&](int, VkExtent2D extent, std::span<const uint8_t> rgba8) {
      image.width = extent.width;
      image.height = extent.height;
      image.rgba8.assign(rgba8.begin(), rgba8.end());
    });
    return image;
  }
  sinks::FrameImage draw(const ImDrawData& panels, const gui::Gui& gui) {
    return draw(&panels, &gui.fonts(), gui.fonts_number());
  }

 private:
  state::PoseState poses_;
  gpu::FrameRing frames_;
  passes::SceneRenderer renderer_;
  gpu::ReadbackRing<int> readback_;
  gui::GuiPass pass_;
  const scene::Scene& scene_;
  const VkExtent2D extent_;
};

float coverage_at(const ImFontAtlas& fonts, glm::vec2 uv) {
  const glm::vec2 size(fonts.TexWidth, fonts.TexHeight);
  const glm::vec2 at = uv * size - 0.5f;
  const glm::ivec2 low(glm::floor(at));
  const glm::vec2 part = at - glm::vec2(low);
  const auto texel = [&](int x, int y) {
    const glm::ivec2 p = glm::clamp(low + glm::ivec2(x, y), glm::ivec2(0), glm::ivec2(size) - 1);
    return static_cast<float>(fonts.TexPixelsAlpha8[p.y * fonts.TexWidth + p.x]) / 255;
  };
  return glm::mix(glm::mix(texel(0, 0), texel(1, 0), part.x), glm::mix(texel(0, 1), texel(1, 1), part.x),
                  part.y);
}

glm::dvec2 place(const ImDrawVert& vertex) {
  return {vertex.pos.x, vertex.pos.y};
}
glm::vec4 color_of(ImU32 packed) {
  const ImVec4 c = ImGui::ColorConvertU32ToFloat4(packed);
  return {c.x, c.y, c.z, c.w};
}

// Draws the triangles in order, in double precision. near: distance of each pixel to the nearest edge, in
// pixels.
void lay_over(std::vector<glm::vec3>& image, std::vector<float>& near, const ImDrawVert* (&v)[3],
              const ImVec4& clip, const ImFontAtlas& fonts) {
  const glm::dvec2 a = place(*v[0]), b = place(*v[1]), c = place(*v[2]);
  const auto cross = [](glm::dvec2 p, glm::dvec2 q) { return p.x * q.y - p.y * q.x; };
  const double area = cross(b - a, c - a);
  if (std::abs(area) < 1e-6) return;
  const glm::dvec2 low = glm::max(glm::min(glm::min(a, b), c), glm::dvec2(clip.x, clip.y));
  const glm::dvec2 high = glm::min(glm::max(glm::max(a, b), c), glm::dvec2(clip.z, clip.w));
  for (int y = std::max(0, int(low.y) - 1); y <= std::min(int(kHeight) - 1, int(high.y) + 1); ++y) {
    for (int x = std::max(0, int(low.x) - 1); x <= std::min(int(kWidth) - 1, int(high.x) + 1); ++x) {
      const glm::dvec2 at(x + 0.5, y + 0.5);
      if (at.x < clip.x || at.y < clip.y || at.x >= clip.z || at.y >= clip.w) continue;
      const double wa = cross(c - b, at - b) / area, wb = cross(a - c, at - c) / area, wc = 1 - wa - wb;
      const double least = std::min({wa, wb, wc}) * std::abs(area);
      const size_t pixel = size_t(y) * kWidth + size_t(x);
      near[pixel] = std::min(near[pixel], float(std::abs(least)));
      if (least < 0) continue;
      const auto mixed = [&](auto value) {
        return float(wa) * value(*v[0]) + float(wb) * value(*v[1]) + float(wc) * value(*v[2]);
      };
      const glm::vec4 color = mixed([](const ImDrawVert& w) { return color_of(w.col); });
      const glm::vec2 uv = mixed([](const ImDrawVert& w) { return glm::vec2(w.uv.x, w.uv.y); });
      image[pixel] = glm::mix(image[pixel], glm::vec3(color), color.a * coverage_at(fonts, uv));
    }
  }
}

TEST_F(GuiPicture, PixelsAreWhatTrianglesSay) {
  GuiWorld world;
  world.display_px = {kWidth, kHeight};
  world.view_state.help = true;
  world.view_state.selected = 2;
  world.frame({gui::MouseMoved{{40, 60}}});
  const ImDrawData& panels = world.settle();
  const ImFontAtlas& fonts = world.gui.fonts();
  Screen screen(world.scene);
  const sinks::FrameImage bare = screen.draw(nullptr, nullptr, 0);
  const sinks::FrameImage drawn = screen.draw(panels, world.gui);
  ASSERT_EQ(drawn.rgba8.size(), size_t{4} * kWidth * kHeight);

  std::vector<glm::vec3> wanted(size_t{kWidth} * kHeight);
  std::vector<float> near(wanted.size(), 1e9f);
  for (size_t i = 0; i < wanted.size(); ++i)
    wanted[i] = glm::vec3(bare.rgba8[4 * i], bare.rgba8[4 * i + 1], bare.rgba8[4 * i + 2]) / 255.0f;
  for (int l = 0; l < panels.CmdListsCount; ++l) {
    const ImDrawList& list = *panels.CmdLists[l];
    for (const ImDrawCmd& command : list.CmdBuffer) {
      for (uint32_t i = command.IdxOffset; i < command.IdxOffset + command.ElemCount; i += 3) {
        const ImDrawVert* corners[3];
        for (uint32_t k = 0; k < 3; ++k)
          corners[k] = &list.VtxBuffer[int(list.IdxBuffer[int(i + k)] + command.VtxOffset)];
        lay_over(wanted, near, corners, command.ClipRect, fonts);
      }
    }
  }
  size_t off = 0, touched = 0, compared = 0;
  for (size_t i = 0; i < wanted.size(); ++i) {
    const glm::vec3 got = glm::vec3(drawn.rgba8[4 * i], drawn.rgba8[4 * i + 1], drawn.rgba8[4 * i + 2]);
    touched += near[i] < 1e8f;
    // Skips pixels whose centre lies on an edge, which may belong to either side, and seams of two triangles.
    if (near[i] < 0.02f) continue;
    ++compared;
    const glm::vec3 d = glm::abs(got - wanted[i] * 255.0f);
    off += std::max({d.r, d.g, d.b}) > 2.5f;
  }
  EXPECT_GT(touched, size_t{kWidth} * kHeight / 2);
  EXPECT_GT(compared, size_t{kWidth} * kHeight * 8 / 10);
  EXPECT_EQ(off, 0u);
}

// Two triangles with a common edge share no pixel and leave no gap at any angle; half transparent colours
// would show both.
TEST_F(GuiPicture, SeamsAreNotSeen) {
  GuiWorld world;
  world.frame();
  ImDrawListSharedData* const shared = ImGui::GetDrawListSharedData();
  ImDrawList list(shared);
  list._ResetForNewFrame();
  list.PushClipRectFullScreen();
  list.PushTextureID(world.gui.fonts().TexID);
  list.Flags = 0;                       // without anti-aliased edges
  const ImVec2 middle{350.5f, 210.5f};  // the first edge passes through pixel centres
  constexpr int kSpokes = 37;
  for (int i = 0; i < kSpokes; ++i) {
    const float from = float(i) / kSpokes * 6.2831853f, to = float((i + 1) % kSpokes) / kSpokes * 6.2831853f;
    list.AddTriangleFilled(middle, {middle.x + 180 * std::cos(from), middle.y + 180 * std::sin(from)},
                           {middle.x + 180 * std::cos(to), middle.y + 180 * std::sin(to)},
                           IM_COL32(255, 0, 0, 128));
  }
  ImDrawData data;
  data.Valid = true;
#if IMGUI_VERSION_NUM >= 18980
  data.CmdLists.push_back(&list);
#else
  ImDrawList* lists[] = {&list};
  data.CmdLists = lists;
#endif
  data.CmdListsCount = 1;
  data.DisplaySize = {kWidth, kHeight};

  SceneBuilder nothing;
  nothing.camera_node("camera", {0, 0, 1}, {0, 0, 0});
  const scene::Scene empty = nothing.build();
  Screen screen(empty);
  const glm::ivec3 background = pixel(screen.draw(nullptr, nullptr, 0), 1, 1);
  const sinks::FrameImage drawn = screen.draw(data, world.gui);
  const glm::vec3 once = glm::mix(glm::vec3(background), glm::vec3(255, 0, 0), 128.0f / 255);
  for (uint32_t y = 0; y < kHeight; ++y) {
    for (uint32_t x = 0; x < kWidth; ++x) {
      const float away = glm::length(glm::vec2(x + 0.5f - middle.x, y + 0.5f - middle.y));
      if (away > 178 && away < 182) continue;
      const glm::vec3 wanted = away < 180 ? once : glm::vec3(background);
      ASSERT_LE(glm::length(glm::vec3(pixel(drawn, x, y)) - wanted), 2) << x << ", " << y;
    }
  }
}

TEST_F(GuiPicture, RemovedPanelLeavesNothing) {
  device().retire_all_now();
  const gpu::LiveObjects before = device().live_objects();
  const uint64_t bytes = device().allocated_bytes();
  {
    GuiWorld world;
    Screen screen(world.scene);
    for (int i = 0; i < 6; ++i) {
      world.display_px = {kWidth, kHeight};
      world.scale = i < 3 ? 1.0f : 1.5f;  // replaces the font atlas while frames are in flight
      screen.draw(world.frame(), world.gui);
    }
    world.view_state.gui = false;
    world.settle();
    const sinks::FrameImage off = screen.draw(world.frame(), world.gui);
    EXPECT_EQ(off.rgba8, screen.draw(nullptr, nullptr, 0).rgba8);
  }
  device().retire_all_now();
  EXPECT_EQ(device().live_objects(), before);
  EXPECT_EQ(device().allocated_bytes(), bytes);
}

}  // namespace
}  // namespace fire3dv::test
