#include "renderer/settings/setting_table.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <system_error>
#include <tuple>
#include <utility>

#include "base/color/srgb.h"
#include "base/error.h"
#include "base/numbers.h"
#include "base/words.h"

namespace fire3dv::settings {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kMaxFinite = 1e6f;

// Without digits that rounding adds, for bounds and degrees.
std::string short_text(float value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.7g", static_cast<double>(value));
  return text;
}

// Bounds of a number, and the words of its error.
struct NumberRange {
  float least, most;
};

std::string check_number_in(const std::string& text, const NumberRange& range) {
  const std::optional<float> value = parse_number<float>(text);
  if (value && std::isfinite(*value) && *value >= range.least && *value <= range.most) return "";
  if (range.most == kInfinity) return text + " is not a number above 0";
  if (range.least == -range.most)
    return text + " is not a number between " + short_text(range.least) + " and " + short_text(range.most);
  return text + " is not a number from " + short_text(range.least) + " to " + short_text(range.most);
}

std::string list_text(std::string label, const std::vector<std::string>& names) {
  for (size_t i = 0; i < names.size(); ++i)
    label += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  return label;
}

// --- kinds of rows. field: function that returns a reference to the value in DrawSettings, or a tie ---

// Such a function of a member.
#define FIELD(member)       \
  [](auto& draw) -> auto& { \
    return draw.member;     \
  }

template <typename Field>
void set_access(DrawSetting& row, Field field) {
  row.is_same = [field](const DrawSettings& a, const DrawSettings& b) { return field(a) == field(b); };
  row.copy = [field](const DrawSettings& from, DrawSettings& to) { field(to) = field(from); };
}

template <typename Value>
struct NamedValue {
  const char* name;
  Value value;
};

// Choice of names; each one stands for a value. set_value writes it, and what belongs to it.
template <typename Value>
DrawSetting choice(std::vector<NamedValue<Value>> values, std::function<Value(const DrawSettings&)> value_of,
                   std::function<void(const Value&, DrawSettings&)> set_value) {
  DrawSetting row;
  row.kind = SettingKind::choice;
  for (const NamedValue<Value>& named : values) row.names.emplace_back(named.name);
  row.value_name = "NAME";
  row.text = [values, value_of](const DrawSettings& draw) {
    const auto named = std::find_if(values.begin(), values.end(), [&](const NamedValue<Value>& candidate) {
      return candidate.value == value_of(draw);
    });
    return std::string((named == values.end() ? values.front() : *named).name);
  };
  row.set = [values, set_value, names = row.names](const std::string& text, DrawSettings& draw) {
    for (const NamedValue<Value>& named : values) {
      if (text != named.name) continue;
      set_value(named.value, draw);
      return std::string();
    }
    return list_text(text + " is not ", names);
  };
  row.is_same = [value_of](const DrawSettings& a, const DrawSettings& b) {
    return value_of(a) == value_of(b);
  };
  row.copy = [value_of, set_value](const DrawSettings& from, DrawSettings& to) {
    set_value(value_of(from), to);
  };
  return row;
}

template <typename Value, typename Field>
DrawSetting choice(std::vector<NamedValue<Value>> values, Field field) {
  return choice<Value>(
      std::move(values), [field](const DrawSettings& draw) { return field(draw); },
      [field](const Value& value, DrawSettings& draw) { field(draw) = value; });
}

template <typename Field>
DrawSetting flag(Field field) {
  DrawSetting row = choice<bool>({{"on", true}, {"off", false}}, field);
  row.value_name = "on|off";
  return row;
}

template <typename Field>
DrawSetting count(uint32_t least, uint32_t most, Field field) {
  DrawSetting row;
  row.kind = SettingKind::count;
  row.value_name = "N";
  row.min_count = least;
  row.max_count = most;
  row.text = [field](const DrawSettings& draw) { return std::to_string(field(draw)); };
  row.set = [field, least, most](const std::string& text, DrawSettings& draw) {
    const std::optional<uint32_t> value = parse_number<uint32_t>(text);
    if (!value || *value < least || *value > most)
      return text + " is not a whole number from " + std::to_string(least) + " to " + std::to_string(most);
    field(draw) = *value;
    return std::string();
  };
  set_access(row, field);
  return row;
}

template <typename Field>
DrawSetting number(const NumberRange& range, Field field) {
  DrawSetting row;
  row.kind = SettingKind::number;
  row.value_name = "X";
  row.min_number = range.least;
  row.max_number = range.most;
  row.text = [field](const DrawSettings& draw) { return number_text(field(draw)); };
  row.set = [field, range](const std::string& text, DrawSettings& draw) {
    std::string wrong = check_number_in(text, range);
    if (wrong.empty()) field(draw) = *parse_number<float>(text);
    return wrong;
  };
  set_access(row, field);
  return row;
}

// Control of a part of a row's value; part: has the part alone.
SettingControl control_of(SettingControl control, const DrawSetting& part) {
  if (part.kind == SettingKind::choice)
    control.kind = control.names.empty() ? ControlKind::check : ControlKind::choice;
  control.values = part.names;
  control.text = part.text;
  control.set = part.set;
  return control;
}

SettingControl shown_if(std::function<bool(const DrawSettings&)> is_shown, SettingControl control) {
  control.is_shown = std::move(is_shown);
  return control;
}

// --- rows of their own kind ---

DrawSetting environment_rotation() {
  DrawSetting row = number({-kMaxFinite, kMaxFinite}, FIELD(environment_rotation_rad));
  row.text = [](const DrawSettings& draw) { return short_text(glm::degrees(draw.environment_rotation_rad)); };
  row.set = [degrees = row.set](const std::string& text, DrawSettings& draw) {
    std::string wrong = degrees(text, draw);
    if (wrong.empty()) draw.environment_rotation_rad = glm::radians(draw.environment_rotation_rad);
    return wrong;
  };
  return row;
}

// Digits of an sRGB colour.
std::optional<glm::vec3> parse_color(std::string_view text) {
  if (text.starts_with('#')) text.remove_prefix(1);  // optional: shells treat # as a comment
  const std::optional<uint32_t> rgb = parse_number<uint32_t>(text, 16);
  if (!rgb || text.size() != 6) return std::nullopt;
  glm::vec3 color;
  for (int c = 0; c < 3; ++c)
    color[c] = linear_from_srgb(static_cast<float>(*rgb >> (16 - 8 * c) & 0xff) / 255);
  return color;
}

std::string color_text(const glm::vec3& color) {
  std::array<int, 3> rgb;
  for (int c = 0; c < 3; ++c)
    rgb[static_cast<size_t>(c)] =
        static_cast<int>(std::lround(255 * std::clamp(srgb_from_linear(color[c]), 0.0f, 1.0f)));
  char text[8];
  std::snprintf(text, sizeof(text), "%02x%02x%02x", rgb[0], rgb[1], rgb[2]);
  return text;
}

SettingControl color_control(const char* label, std::function<glm::vec3&(DrawSettings&)> color) {
  SettingControl control{label};
  control.kind = ControlKind::color;
  control.text = [color](const DrawSettings& draw) {
    DrawSettings copy = draw;
    return color_text(color(copy));
  };
  control.set = [color](const std::string& text, DrawSettings& draw) {
    const std::optional<glm::vec3> parsed = parse_color(text);
    if (parsed) color(draw) = *parsed;
    return parsed ? std::string() : text + " is not a colour such as 20a0ff";
  };
  control.color = std::move(color);
  return control;
}

std::string background_text(const DrawSettings& draw) {
  const Background& background = draw.background;
  if (background.show_environment) return "environment";
  if (background == Background::automatic()) return "auto";
  if (background == Background::gradient()) return "gradient";
  return color_text(background.color);
}

std::string set_background(const std::string& text, DrawSettings& draw) {
  if (text == "environment") {
    draw.background.show_environment = true;
  } else if (text == "auto") {
    draw.background = Background::automatic();
  } else if (text == "gradient") {
    draw.background = Background::gradient();
  } else if (const std::optional<glm::vec3> color = parse_color(text)) {
    draw.background = {false, *color, std::nullopt};
  } else {
    return "must be auto, gradient, environment or a colour such as 20a0ff";
  }
  return "";
}

DrawSetting background() {
  DrawSetting row;
  row.value_name = "COLOR";
  row.shows_default = false;
  row.text = background_text;
  row.set = set_background;
  set_access(row, FIELD(background));
  const auto has_colors = [](const DrawSettings& draw) { return !draw.background.show_environment; };
  const auto has_zenith = [](const DrawSettings& draw) {
    return !draw.background.show_environment && draw.background.zenith;
  };
  row.controls = {
      control_of({"  as background", "Behind the scene, instead of a colour"},
                 flag(FIELD(background.show_environment))),
      shown_if(has_colors, control_of({"  sky of the scene", "Behind the scene, if its file has one"},
                                      flag(FIELD(background.show_sky)))),
      shown_if(has_colors,
               color_control("Background",
                             [](DrawSettings& draw) -> glm::vec3& { return draw.background.color; })),
      shown_if(has_zenith, color_control("  at zenith", [](DrawSettings& draw) -> glm::vec3& {
                 return *draw.background.zenith;
               }))};
  return row;
}

DrawSetting exposure() {
  DrawSetting row;
  row.kind = SettingKind::number;
  row.value_name = "X|auto|metered";
  row.text = [](const DrawSettings& draw) {
    if (draw.post.metered) return std::string("metered");
    return draw.post.estimated ? std::string("auto") : number_text(draw.post.exposure);
  };
  row.set = [](const std::string& text, DrawSettings& draw) {
    PostSettings& post = draw.post;
    const bool is_number = text != "auto" && text != "metered";
    if (is_number) {
      if (const std::string wrong = positive_number(text); !wrong.empty()) return wrong + ", auto or metered";
      post.exposure = *parse_number<float>(text);
    }
    post.metered = text == "metered";
    post.estimated = !is_number;
    return std::string();
  };
  set_access(row,
             [](auto& draw) { return std::tie(draw.post.exposure, draw.post.metered, draw.post.estimated); });
  row.controls = {shown_if([](const DrawSettings& draw) { return !draw.post.metered; },
                           control_of({"Exposure", nullptr, {}, 1.0f / 64, 64, "%.2f x", true},
                                      number({0, kInfinity}, FIELD(post.exposure))))};
  return row;
}

using ShadowChoice = std::tuple<ShadowMethod, RayBackEnd, bool>;  // the last: small maps

// The back end of shadow rays is that of ray effects, too.
DrawSetting shadows() {
  DrawSetting row = choice<ShadowChoice>(
      {{"auto", {ShadowMethod::automatic, RayBackEnd::query, false}},
       {"ray", {ShadowMethod::ray, RayBackEnd::query, false}},
       {"ray-query", {ShadowMethod::ray, RayBackEnd::query, false}},
       {"ray-pipeline", {ShadowMethod::ray, RayBackEnd::pipeline, false}},
       {"map", {ShadowMethod::map, RayBackEnd::query, false}},
       {"small-map", {ShadowMethod::map, RayBackEnd::query, true}},
       {"off", {ShadowMethod::off, RayBackEnd::query, false}}},
      [](const DrawSettings& draw) {
        return ShadowChoice(draw.shadows.method, draw.shadows.back_end, draw.shadows.small_maps);
      },
      [](const ShadowChoice& value, DrawSettings& draw) {
        std::tie(draw.shadows.method, draw.shadows.back_end, draw.shadows.small_maps) = value;
        draw.ray_effects.back_end = draw.shadows.back_end;
      });
  row.help = joined(row.names, "|");
  // The back end stays.
  using Method = std::tuple<ShadowMethod, bool>;
  row.controls = {control_of(
      {"Shadows", nullptr, {"automatic", "rays", "maps alone", "small maps alone", "off"}},
      choice<Method>({{"auto", {ShadowMethod::automatic, false}},
                      {"ray", {ShadowMethod::ray, false}},
                      {"map", {ShadowMethod::map, false}},
                      {"small-map", {ShadowMethod::map, true}},
                      {"off", {ShadowMethod::off, false}}},
                     [](auto& draw) { return std::tie(draw.shadows.method, draw.shadows.small_maps); }))};
  return row;
}

DrawSetting samples() {
  DrawSetting row = count(1, 64, FIELD(samples));
  row.set = [set = row.set](const std::string& text, DrawSettings& draw) {
    std::string wrong = set(text, draw);
    if (wrong.empty()) draw.keeps_samples = true;
    return wrong;
  };
  row.controls = {control_of(
      {"Samples", "Of each pixel", {"1", "4"}},
      choice<bool>(
          {{"1", false}, {"4", true}}, [](const DrawSettings& draw) { return draw.samples > 1; },
          [set = row.set](bool several, DrawSettings& draw) { (void)set(several ? "4" : "1", draw); }))};
  return row;
}

DrawSetting ray_effects() {
  DrawSetting row;
  row.value_name = "LIST";
  row.text = [](const DrawSettings& draw) {
    std::string names = describe(draw.ray_effects.on);
    std::erase(names, ' ');
    return names.empty() ? "off" : names;
  };
  row.set = [](const std::string& text, DrawSettings& draw) {
    RayEffects on;
    if (!ray_effects_named(text, on))
      return "must be off, all, or names separated by commas: " + ray_effect_names();
    draw.ray_effects.on = on;
    return std::string();
  };
  set_access(row, FIELD(ray_effects.on));
  const auto effect = [&row](const char* label, const char* hint, bool RayEffects::*on) {
    row.controls.push_back(
        control_of({label, hint}, flag([on](auto& draw) -> auto& { return draw.ray_effects.on.*on; })));
  };
  effect("Reflections by rays", "Smooth surfaces mirror bodies; needs rays on the device",
         &RayEffects::reflections);
  effect("Ambient occlusion", "Less light of the environment in corners; needs rays on the device",
         &RayEffects::ambient_occlusion);
  effect("Refraction", "Glass bends light; needs rays on the device", &RayEffects::refraction);
  effect("Diffuse bounce", "Surfaces light each other; needs rays on the device", &RayEffects::bounce);
  return row;
}

DrawSetting ray_effect_rays() {
  DrawSetting row = count(1, 16, FIELD(ray_effects.reflection_rays));
  const auto set_all = [](DrawSettings& draw) {
    draw.ray_effects.set_rays(draw.ray_effects.reflection_rays);
  };
  row.set = [set_all, set = row.set](const std::string& text, DrawSettings& draw) {
    std::string wrong = set(text, draw);
    if (wrong.empty()) set_all(draw);
    return wrong;
  };
  set_access(row, [](auto& draw) {
    auto& effects = draw.ray_effects;
    return std::tie(effects.reflection_rays, effects.occlusion_rays, effects.bounce_rays);
  });
  return row;
}

DrawSetting render() {
  DrawSetting row = choice<bool>(
      {{"raster", false}, {"path", true}}, [](const DrawSettings& draw) { return draw.path.has_value(); },
      [](bool traces, DrawSettings& draw) {
        if (traces == draw.path.has_value()) return;
        draw.path.reset();
        if (traces) draw.path.emplace().lens = draw.post.lens;
      });
  row.value_name = "raster|path";
  row.copy = [](const DrawSettings& from, DrawSettings& to) {
    if (from.path.has_value() != to.path.has_value()) to.path = from.path;
  };
  row.controls = {{"Renderer", "Paths: a reference image that refines at rest", {"raster", "paths"}}};
  return row;
}

// Number of the path tracer, which is the default while the raster draws.
DrawSetting path_count(uint32_t least, uint32_t most, uint32_t PathSettings::*value) {
  DrawSetting row = count(least, most, FIELD(samples));
  row.needs_paths = true;
  const auto value_of = [value](const DrawSettings& draw) {
    return draw.path.value_or(PathSettings()).*value;
  };
  row.text = [value_of](const DrawSettings& draw) { return std::to_string(value_of(draw)); };
  row.set = [value, set = row.set](const std::string& text, DrawSettings& draw) {
    DrawSettings parsed;
    std::string wrong = set(text, parsed);
    if (wrong.empty() && draw.path) (*draw.path).*value = parsed.samples;
    return wrong;
  };
  row.is_same = [value_of](const DrawSettings& a, const DrawSettings& b) {
    return !a.path || !b.path || value_of(a) == value_of(b);
  };
  row.copy = [value](const DrawSettings& from, DrawSettings& to) {
    if (from.path && to.path) (*to.path).*value = (*from.path).*value;
  };
  return row;
}

// Raster and paths share the lens.
void set_lens(const scene::ThinLens& lens, DrawSettings& draw) {
  draw.post.lens = lens;
  if (draw.path) draw.path->lens = lens;
}

// Number of that lens.
DrawSetting lens_number(const NumberRange& range, float scene::ThinLens::*value) {
  DrawSetting row = number(
      range, [value](auto& draw) -> auto& { return draw.post.lens.*value; });
  row.shows_default = false;
  row.set = [set = row.set](const std::string& text, DrawSettings& draw) {
    std::string wrong = set(text, draw);
    if (wrong.empty()) set_lens(draw.post.lens, draw);
    return wrong;
  };
  row.is_same = [value, post = row.is_same](const DrawSettings& a, const DrawSettings& b) {
    return post(a, b) && (!a.path || !b.path || a.path->lens.*value == b.path->lens.*value);
  };
  row.copy = [value, post = row.copy](const DrawSettings& from, DrawSettings& to) {
    post(from, to);
    if (from.path && to.path) to.path->lens.*value = from.path->lens.*value;
  };
  return row;
}

// --- presets of the camera ---

// Settings of a preset, by name and value. Sources: docs/endoscope.md.
constexpr std::pair<const char*, const char*> kEndoscope[] = {
    {"lamps", "2"},           {"lamp-intensity", "1"},
    {"lamp-spread", "2.767"}, {"lamp-offset", "3.8"},
    {"vignette", "2"},        {"mask-radius", "1.15"},
    {"mask-cut", "0.96"},     {"aberration", "0.0015"},
    {"response", "2.2"},      {"fog", "0.05"},
    {"fog-blur", "4"},        {"fog-veil", "0.2"},
    {"full-well", "10000"},   {"read-noise", "4"},
    {"prnu", "0.5"},          {"dsnu", "2"},
    {"exposure", "metered"},  {"bloom", "0.03"},
    {"background", "000000"}, {"environment-intensity", "0"},
    {"f-number", "34"},       {"focus-distance", "0.055"},
};

// Also sets the settings that belong to it.
DrawSetting camera_preset() {
  DrawSetting row;
  row.kind = SettingKind::choice;
  row.names = {"none", "endoscope"};
  row.value_name = "NAME";
  row.is_preset = true;
  row.text = [](const DrawSettings& draw) {
    DrawSettings with_preset = draw;
    for (const auto& [name, value] : kEndoscope) (void)draw_setting(name).set(value, with_preset);
    const bool is_set = std::all_of(std::begin(kEndoscope), std::end(kEndoscope), [&](const auto& value) {
      return draw_setting(value.first).is_same(draw, with_preset);
    });
    return std::string(is_set ? "endoscope" : "none");
  };
  row.set = [names = row.names](const std::string& text, DrawSettings& draw) {
    if (text != "none" && text != "endoscope") return list_text(text + " is not ", names);
    const DrawSettings defaults = default_settings();
    for (const auto& [name, value] : kEndoscope) {
      const DrawSetting& setting = draw_setting(name);
      if (text == "none")
        setting.copy(defaults, draw);
      else
        (void)setting.set(value, draw);
    }
    set_lens(draw.post.lens, draw);  // the defaults trace no paths
    return std::string();
  };
  row.is_same = [](const DrawSettings&, const DrawSettings&) { return true; };
  row.copy = [](const DrawSettings&, DrawSettings&) {};
  return row;
}

// Adds rows of a group to the table.
class Rows {
 public:
  Rows(std::vector<DrawSetting>& table, SettingGroup group) : table_(table), group_(group) {}

  DrawSetting& add(const char* name, const char* help, Invalidates invalidates, int users, DrawSetting row) {
    row.name = name;
    if (help) row.help = help;
    row.group = group_;
    row.invalidates = invalidates;
    row.users = static_cast<uint8_t>(users);
    return table_.emplace_back(std::move(row));
  }

 private:
  std::vector<DrawSetting>& table_;
  SettingGroup group_;
};

constexpr int kByPrograms = kByCommandLine | kByDrake;

std::vector<DrawSetting> make_table() {
  std::vector<DrawSetting> table;
  // First, so that options beside the preset win.
  Rows optics(table, SettingGroup::optics);
  DrawSetting* row =
      &optics.add("camera-preset", "endoscope: sets lamps, mask, sensor and more (manual)",
                  Invalidates::renderer, kByPrograms | kByWindow | kByBrowser, camera_preset());
  row->controls = {{"Camera",
                    "Sets lamps, lens, mask, exposure and sensor; each can be changed after it",
                    {"plain", "endoscope"}}};
  const auto add_number = [&](const char* name, const char* value_name, const char* help,
                              Invalidates invalidates, const NumberRange& range, auto field) -> DrawSetting& {
    DrawSetting& added = optics.add(name, help, invalidates, kByPrograms | kByWindow, number(range, field));
    added.value_name = value_name;
    return added;
  };
  row = &optics.add("lamps", "lamps beside the lens, 0 to 8", Invalidates::renderer, kByPrograms | kByWindow,
                    count(0, 8, FIELD(lamps.count)));
  row->controls = {{"Lamps", "Beside the lens, fixed to the camera", {}, 0, 8, "%.0f"}};
  const auto has_lamps = [](const DrawSettings& draw) { return draw.lamps.count > 0; };
  add_number("lamp-intensity", "CD", "of each lamp, candela", Invalidates::shading, {0, kMaxFinite},
             FIELD(lamps.intensity_cd))
      .controls = {shown_if(has_lamps, {"  intensity", "Of each lamp", {}, 0, 100, "%.2f cd", true})};
  add_number("lamp-spread", "MU", "intensity falls as exp(-MU (1 - cos angle))", Invalidates::shading,
             {0, 100}, FIELD(lamps.spread))
      .controls = {shown_if(has_lamps, {"  spread", "0: the same in all directions", {}, 0, 20, "%.2f"})};
  add_number("lamp-offset", "MM", "millimetres from the axis to the lamps", Invalidates::shading, {0, 1000},
             FIELD(lamps.offset_mm))
      .controls = {shown_if(has_lamps, {"  offset", "From the optical axis", {}, 0, 20, "%.1f mm"})};
  add_number("vignette", "K", "light falls as cos^K off the axis, 0 to 16", Invalidates::post, {0, 16},
             FIELD(post.optics.vignette))
      .controls = {{"Vignette", "Exponent of the cosine off the axis; 4: a simple lens", {}, 0, 8, "%.1f"}};
  add_number("mask-radius", "R", "content mask, in halves of the height; 0: none", Invalidates::post, {0, 4},
             FIELD(post.optics.mask_radius))
      .controls = {{"Content mask", "Radius in halves of the image's height; 0: none", {}, 0, 2, "%.2f"}};
  add_number("mask-cut", "C", "cuts the mask above and below; 0: a whole disc", Invalidates::post, {0, 4},
             FIELD(post.optics.mask_cut))
      .controls = {shown_if([](const DrawSettings& draw) { return draw.post.optics.mask_radius > 0; },
                            {"  cut", "Half the height that is left; 0: a whole disc", {}, 0, 2, "%.2f"})};
  add_number("aberration", "A", "lateral colour: size of red 1 + A, of blue 1 - A", Invalidates::post,
             {-0.1f, 0.1f}, FIELD(post.optics.aberration))
      .controls = {{"Lateral colour", "Size of red over green, less 1", {}, -0.01f, 0.01f, "%.4f"}};
  add_number("response", "GAMMA", "response curve x^(1/GAMMA); 0: tone mapping", Invalidates::post, {0, 10},
             FIELD(post.optics.response))
      .controls = {{"Response", "x^(1 / gamma) instead of tone mapping; 0: off", {}, 0, 4, "gamma %.2f"}};
  add_number("fog", "C", "share of the window that is fogged, 0 to 1", Invalidates::post, {0, 1},
             FIELD(post.optics.fog))
      .controls = {{"Fog", "Share of the window that is fogged", {}, 0, 1, "%.2f"}};
  const auto has_fog = [](const DrawSettings& draw) { return draw.post.optics.fog > 0; };
  add_number("fog-blur", "DEG", "standard deviation of the fog's blur", Invalidates::post, {0.1f, 45},
             FIELD(post.optics.fog_blur_deg))
      .controls = {shown_if(has_fog, {"  fog blur", nullptr, {}, 0.5f, 20, "%.1f \u00b0"})};
  add_number("fog-veil", "V", "share of fogged light spread over the image", Invalidates::post, {0, 1},
             FIELD(post.optics.fog_veil))
      .controls = {shown_if(
      has_fog, {"  fog veil", "Share of its light that is over all of the image", {}, 0, 1, "%.2f"})};
  add_number("drops", "C", "share of the window under drops, 0 to 0.4", Invalidates::post, {0, 0.4f},
             FIELD(post.optics.drops))
      .controls = {{"Drops", "Share of the window under drops", {}, 0, 0.4f, "%.2f"}};
  add_number("drop-size", "DEG", "largest diameter of drops as seen", Invalidates::post, {0.5f, 90},
             FIELD(post.optics.drop_size_deg))
      .controls = {shown_if([](const DrawSettings& draw) { return draw.post.optics.drops > 0; },
                            {"  drop size", nullptr, {}, 1, 40, "%.1f \u00b0"})};
  add_number("full-well", "E", "electrons of a full pixel; 0: no sensor noise", Invalidates::post,
             {0, kMaxFinite}, FIELD(post.optics.full_well))
      .controls = {{"Full well", "Electrons of a full pixel; 0: no noise", {}, 0, 100'000, "%.0f e", true}};
  const auto has_noise = [](const DrawSettings& draw) { return draw.post.optics.full_well > 0; };
  add_number("read-noise", "E", "standard deviation in the dark, electrons", Invalidates::post, {0, 10'000},
             FIELD(post.optics.read_noise))
      .controls = {shown_if(has_noise, {"  read noise", nullptr, {}, 0, 100, "%.1f e", true})};
  add_number("dark-signal", "E", "mean in the dark, electrons", Invalidates::post, {0, kMaxFinite},
             FIELD(post.optics.dark_signal))
      .controls = {shown_if(has_noise, {"  dark signal", nullptr, {}, 0, 1000, "%.0f e", true})};
  add_number("prnu", "PERCENT", "deviation of the pixels' sensitivities", Invalidates::post, {0, 100},
             FIELD(post.optics.prnu_percent))
      .controls = {shown_if(has_noise, {"  PRNU", "Of the pixels' sensitivities", {}, 0, 5, "%.2f %%"})};
  add_number("dsnu", "E", "deviation of the pixels' dark signals, electrons", Invalidates::post, {0, 10'000},
             FIELD(post.optics.dsnu))
      .controls = {
      shown_if(has_noise, {"  DSNU", "Of the pixels' dark signals", {}, 0, 100, "%.1f e", true})};
  row = &optics.add("noise-seed", "seed of sensor noise and drops", Invalidates::post,
                    kByPrograms | kByWindow, count(0, UINT32_MAX, FIELD(post.optics.noise_seed)));
  row->controls = {shown_if(
      [](const DrawSettings& draw) { return draw.post.optics.full_well > 0 || draw.post.optics.drops > 0; },
      {"  seed", "Of noise and drops", {}, 0, 1000, "%.0f"})};

  Rows environment(table, SettingGroup::environment);
  row = &environment.add("environment-intensity", "factor on its light", Invalidates::shading,
                         kByPrograms | kByWindow, number({0, kInfinity}, FIELD(environment_intensity)));
  row->controls = {{"Environment", "Factor on its light", {}, 0, 8, "%.2f x"}};
  row = &environment.add("environment-rotation", "degrees, counter-clockwise", Invalidates::shading,
                         kByPrograms | kByWindow, environment_rotation());
  row->value_name = "DEG";
  row->controls = {{"  rotation", nullptr, {}, -180, 180, "%.0f \u00b0"}};
  row = &environment.add("environment-sun", "light with shadows instead of the sun in the image",
                         Invalidates::renderer, kByPrograms | kByWindow,
                         choice<bool>({{"auto", true}, {"off", false}}, FIELD(environment_sun)));
  row->value_name = "auto|off";
  row->controls = {{"  sun as a light", "With shadows; off: as a part of the environment image"}};
  environment.add("background", "auto, gradient, environment, or a colour such as 20a0ff",
                  Invalidates::shading, kByPrograms | kByWindow, background());

  Rows image(table, SettingGroup::image);
  image.add("exposure", "factor on all light; metered: by each image", Invalidates::post,
            kByPrograms | kByWindow, exposure());
  row = &image.add("tone-map", "neutral, aces, reinhard or none", Invalidates::post,
                   kByPrograms | kByWindow | kByBrowser,
                   choice<ToneMap>({{"reinhard", ToneMap::reinhard},
                                    {"aces", ToneMap::aces},
                                    {"neutral", ToneMap::neutral},
                                    {"none", ToneMap::none}},
                                   FIELD(post.tone_map)));
  row->controls = {{"Tone mapping", nullptr, {"Reinhard", "ACES", "neutral", "none"}}};
  row = &image.add("saturation", "factor on the saturation of colours, 0 (grey) to 2", Invalidates::post,
                   kByCommandLine | kByWindow, number({0, 2}, FIELD(post.saturation)));
  row->controls = {{"Saturation", "Of colours after tone mapping", {}, 0, 2, "%.2f x"}};
  image
      .add("shadows", nullptr, Invalidates::renderer, kByPrograms | kByWindow | kByBrowser | kByBench,
           shadows())
      .needs_raster = true;
  row = &image.add("shadow-rays", "rays for uncertain pixels, or for all lit ones", Invalidates::renderer,
                   kByPrograms | kByWindow | kByBench,
                   choice<bool>({{"hybrid", true}, {"all", false}}, FIELD(shadows.hybrid)));
  row->value_name = "hybrid|all";
  row->needs_raster = true;
  row->controls = {shown_if(
      [](const DrawSettings& draw) {
        return draw.shadows.method == ShadowMethod::automatic || draw.shadows.method == ShadowMethod::ray;
      },
      control_of({"Rays everywhere", "Off: only for pixels that shadow maps leave uncertain"},
                 choice<bool>({{"on", false}, {"off", true}}, FIELD(shadows.hybrid))))};
  image
      .add("samples", "samples per pixel at most, 1 to 64", Invalidates::renderer,
           kByPrograms | kByWindow | kByBench, samples())
      .needs_raster = true;
  row = &image.add("fxaa", "post-process antialiasing", Invalidates::post, kByPrograms | kByWindow | kByBench,
                   flag(FIELD(post.fxaa)));
  row->controls = {{"FXAA", "Smooths edges of the finished image"}};
  row->needs_raster = true;
  row = &image.add("bloom", "share of light that a lens scatters, 0 to 1", Invalidates::post, kByPrograms,
                   number({0, 1}, FIELD(post.bloom)));
  row->value_name = "STRENGTH";
  image
      .add("ray-effects", "off, all, or some of reflections,ao,refraction,bounce", Invalidates::pipelines,
           kByPrograms | kByWindow, ray_effects())
      .needs_raster = true;
  image.add("ray-effect-rays", "rays of an effect in a pixel, 1 to 16", Invalidates::shading, kByPrograms,
            ray_effect_rays());
  row = &image.add("anisotropy", "anisotropic texture filtering, 1 to 16", Invalidates::renderer, kByPrograms,
                   number({1, 16}, FIELD(anisotropy)));
  row->value_name = "N";

  row = &image.add("label-alpha", "blended surfaces with more alpha have labels, 0 to 1",
                   Invalidates::nothing, kByCommandLine, number({0, 1}, FIELD(label_alpha)));
  row->value_name = "LIMIT";

  Rows paths(table, SettingGroup::paths);
  paths.add("render", "raster, or paths: a reference image (docs/truth.md)", Invalidates::renderer,
            kByCommandLine | kByWindow | kByBrowser, render());
  row = &paths.add("spp", "path: samples per pixel", Invalidates::shading, kByCommandLine | kByWindow,
                   path_count(1, 1 << 20, &PathSettings::samples_per_pixel));
  row->controls = {{"  samples", "Of each pixel, until the image is whole", {}, 1, 4096, "%.0f", true}};
  row = &paths.add("bounces", "path: bounces after the first surface", Invalidates::shading,
                   kByCommandLine | kByWindow, path_count(0, 1024, &PathSettings::bounces));
  row->controls = {{"  bounces", "After the first surface", {}, 0, 32, "%.0f"}};
  paths.add("seed", "path: seed of the random numbers", Invalidates::shading, kByCommandLine,
            path_count(0, UINT32_MAX, &PathSettings::seed));
  row = &paths.add("f-number", "aperture of the lens", Invalidates::shading, kByCommandLine | kByWindow,
                   lens_number({scene::kMinFNumber, scene::kMaxFNumber}, &scene::ThinLens::f_number));
  row->value_name = "N";
  const auto has_lens = [](const DrawSettings& draw) { return !draw.post.lens.is_pinhole(); };
  row->controls = {control_of({"Lens", "Depth of field; off: the lens of the camera, if it has one"},
                              choice<bool>({{"on", true}, {"off", false}}, has_lens,
                                           [](bool on, DrawSettings& draw) {
                                             set_lens(on ? scene::kUsualLens : scene::ThinLens{}, draw);
                                           })),
                   shown_if(has_lens, {"  f-number", nullptr, {}, scene::kMinFNumber, 32, "f/%.1f", true})};
  row = &paths.add("focus-distance", "metres to the plane in focus", Invalidates::shading,
                   kByCommandLine | kByWindow,
                   lens_number({scene::kMinFocusDistanceM, scene::kMaxFocusDistanceM},
                               &scene::ThinLens::focus_distance_m));
  row->value_name = "M";
  row->controls = {
      shown_if(has_lens, {"  focus", "Distance of sharp things", {}, 0.01f, 100, "%.2f m", true})};

  Rows raster(table, SettingGroup::raster);
  row = &raster.add("raster", nullptr, Invalidates::renderer, kByCommandLine | kByWindow | kByBench,
                    choice<RasterPath>({{"auto", RasterPath::automatic},
                                        {"forward", RasterPath::forward},
                                        {"visibility", RasterPath::visibility}},
                                       FIELD(raster)));
  row->help = list_text("raster path: ", row->names);
  row->controls = {{"Raster path", nullptr, {"automatic", "forward", "visibility"}}};
  row = &raster.add(
      "cull", nullptr, Invalidates::nothing, kByCommandLine | kByWindow | kByBench,
      choice<Cull>(
          {{"on", Cull::automatic}, {"off", Cull::off}, {"view", Cull::view}, {"hidden", Cull::hidden}},
          FIELD(cull)));
  row->help = list_text("cluster culling: ", row->names);
  row->controls = {{"Culling",
                    "Skips invisible clusters; the image stays the same",
                    {"automatic", "off", "out of view", "hidden, too"}}};
  row = &raster.add("lod", nullptr, Invalidates::shading, kByCommandLine | kByWindow | kByBench,
                    choice<LevelsOfDetail>({{"auto", LevelsOfDetail::automatic},
                                            {"on", LevelsOfDetail::camera},
                                            {"surface", LevelsOfDetail::surface},
                                            {"everywhere", LevelsOfDetail::everywhere},
                                            {"off", LevelsOfDetail::off}},
                                           FIELD(levels_of_detail)));
  row->help = list_text("level of detail: ", row->names);
  row->controls = {{"Level of detail",
                    "Coarser triangles where the difference is less than a pixel",
                    {"automatic", "camera", "camera, by surface", "everywhere", "off"}}};
  raster
      .add("motion-quality", "images in motion on a CPU: simpler (auto) or full", Invalidates::nothing,
           kByCommandLine,
           choice<MotionQuality>({{"auto", MotionQuality::automatic}, {"full", MotionQuality::full}},
                                 FIELD(motion_quality)))
      .value_name = "auto|full";
  for (DrawSetting& each : table) {
    if (each.group == SettingGroup::raster) each.needs_raster = true;
    // Of a camera without optics and lamps, the panel has the preset alone.
    if (each.group == SettingGroup::optics && !each.is_preset)
      for (SettingControl& control : each.controls)
        control.is_shown = [inner = control.is_shown](const DrawSettings& draw) {
          return (draw.post.optics.any() || draw.lamps.count > 0) && (!inner || inner(draw));
        };
    for (SettingControl& control : each.controls)
      if (!control.set) control = control_of(std::move(control), each);
  }
  return table;
}

}  // namespace

const std::vector<DrawSetting>& draw_setting_table() {
  static const std::vector<DrawSetting> table = make_table();
  return table;
}

const DrawSetting& draw_setting(std::string_view name) {
  const std::vector<DrawSetting>& table = draw_setting_table();
  const auto row = std::find_if(table.begin(), table.end(),
                                [&](const DrawSetting& setting) { return setting.name == name; });
  FIRE3DV_ASSERT(row != table.end());
  return *row;
}

size_t chosen_index(const SettingControl& control, const DrawSettings& settings) {
  const auto value = std::find(control.values.begin(), control.values.end(), control.text(settings));
  FIRE3DV_ASSERT(value != control.values.end());
  return static_cast<size_t>(value - control.values.begin());
}

bool is_shown(const DrawSetting& setting, const SettingControl& control, const DrawSettings& settings) {
  return (!setting.needs_paths || settings.path) && (!control.is_shown || control.is_shown(settings));
}

void keep_path_settings(bool traced_paths, DrawSettings& draw, PathSettings& paths) {
  if (!draw.path) return;
  if (!traced_paths) draw.path = paths;
  draw.path->lens = draw.post.lens;
  paths = *draw.path;
}

DrawSettings default_settings() {
  DrawSettings settings;
  settings.background = Background::automatic();
  settings.post.tone_map = ToneMap::neutral;
  settings.post.estimated = true;
  return settings;
}

Invalidates compare(const DrawSettings& from, const DrawSettings& to) {
  Invalidates most = Invalidates::nothing;
  for (const DrawSetting& setting : draw_setting_table()) {
    if (!setting.is_same(from, to)) most = std::max(most, setting.invalidates);
  }
  return most;
}

void copy_applicable(const DrawSettings& from, DrawSettings& to) {
  for (const DrawSetting& setting : draw_setting_table()) {
    if (setting.invalidates != Invalidates::renderer) setting.copy(from, to);
  }
}

bool have_same_values(const DrawSettings& a, const DrawSettings& b, uint8_t users) {
  const std::vector<DrawSetting>& table = draw_setting_table();
  return std::all_of(table.begin(), table.end(), [&](const DrawSetting& setting) {
    return !(setting.users & users) || setting.is_same(a, b);
  });
}

std::string number_text(float value) {
  std::array<char, 128> text;
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  FIRE3DV_ASSERT(error == std::errc());
  return {text.data(), end};
}

std::string positive_number(const std::string& text) {
  std::string wrong = check_number_in(text, {0, kInfinity});
  return wrong.empty() && *parse_number<float>(text) == 0 ? text + " is not a number above 0" : wrong;
}

std::string finite_number(const std::string& text) {
  return check_number_in(text, {-kMaxFinite, kMaxFinite});
}

}  // namespace fire3dv::settings
