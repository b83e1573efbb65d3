// Render panel: draw settings and debug views.
#include "renderer/gui/panels.h"

namespace fire3dv::gui {
namespace {

using namespace passes;

// Combo box of an enumeration with values 0, 1, 2, ... in the order of the names.
template <typename Value, size_t count>
void choose(Ui& ui, const char* label, Value& value, const char* const (&names)[count],
            const char* hint = nullptr) {
  size_t chosen = static_cast<size_t>(value);
  if (ui.choice(label, chosen, names, hint)) value = static_cast<Value>(chosen);
}

void choose_samples(Ui& ui, uint32_t& samples) {
  constexpr const char* kNames[] = {"1", "4"};
  size_t chosen = samples > 1 ? 1 : 0;
  if (ui.choice("Samples", chosen, kNames, "Of each pixel")) samples = chosen == 0 ? 1 : 4;
}

void choose_shadows(Ui& ui, ShadowSettings& shadows) {
  constexpr const char* kMethods[] = {"automatic", "rays", "maps alone", "off"};
  choose(ui, "Shadows", shadows.method, kMethods);
  if (shadows.method == ShadowMethod::map || shadows.method == ShadowMethod::off) return;
  bool everywhere = !shadows.hybrid;
  if (ui.check("Rays everywhere", everywhere, "Off: only for pixels that shadow maps leave uncertain"))
    shadows.hybrid = !everywhere;
}

}  // namespace

void draw_render_panel(const Context& context) {
  Ui& ui = context.ui;
  if (!ui.header("Render", context.layout.is_open(Panel::render))) return;
  Viewer& viewer = context.viewer;
  DrawSettings& draw = viewer.draw;
  if (ui.button("Screenshot", true, "A PNG file of the image, without panels  (P)"))
    viewer.commands.screenshot = true;
  ui.same_line();
  const bool recording = context.facts.recording_video;
  if (ui.button(recording ? "Stop video##video" : "Video##video", true, "Of all images from now on  (V)",
                recording))
    viewer.commands.toggle_video = true;

  constexpr const char* kViews[] = {"light",    "normals",  "depth",       "nodes",
                                    "clusters", "overdraw", "shadow doubt"};
  choose(ui, "Shows", viewer.debug_view, kViews, "Debug view instead of light");
  if (!context.facts.why_no_debug_views.empty()) ui.note(context.facts.why_no_debug_views);
  ui.slider("Exposure", draw.post.exposure, {1.0f / 64, 64, "%.2f x", true});
  constexpr const char* kToneMaps[] = {"Reinhard", "ACES", "neutral", "none"};
  choose(ui, "Tone mapping", draw.post.tone_map, kToneMaps);
  ui.check("FXAA", draw.post.fxaa, "Smooths edges of the finished image");
  constexpr const char* kPaths[] = {"automatic", "forward", "visibility"};
  choose(ui, "Raster path", draw.raster, kPaths);
  choose_samples(ui, draw.samples);
  choose_shadows(ui, draw.shadows);
  constexpr const char* kCulls[] = {"off", "out of view", "hidden, too", "automatic"};
  choose(ui, "Culling", draw.cull, kCulls, "Skips invisible clusters; the image stays the same");
  constexpr const char* kLevels[] = {"off", "camera", "everywhere", "automatic"};
  choose(ui, "Level of detail", draw.levels_of_detail, kLevels,
         "Coarser triangles where the difference is less than a pixel");
  ui.slider("Environment", draw.environment_intensity, {0, 8, "%.2f x"}, "Factor on its light");
  float degrees = glm::degrees(draw.environment_rotation_rad);
  if (ui.slider("  turned", degrees, {-180, 180, "%.0f \u00b0"}))
    draw.environment_rotation_rad = glm::radians(degrees);
  ui.check("  seen", draw.background.show_environment, "Behind the scene, instead of a colour");
  if (!draw.background.show_environment) ui.color("Background", draw.background.color);
}

}  // namespace fire3dv::gui
