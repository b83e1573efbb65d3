// Test of the table of draw settings: every row round-trips, refuses bad values and has its declared effect.
#include "renderer/settings/setting_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace fire3dv::settings {
namespace {

using Values = std::pair<std::string, std::string>;

// Values of rows that are not made of names or numbers alone; the first one differs from the default.
const std::map<std::string, Values> kTextValues{
    {"background", {"20a0ff", "environment"}},
    {"exposure", {"2.5", "metered"}},
    {"ray-effects", {"reflections,bounce", "ao"}},
};

std::string text_of(float number) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.7g", static_cast<double>(number));
  return text;
}

// Two values of a row; the first one differs from the default.
Values values_of(const DrawSetting& row) {
  if (const auto values = kTextValues.find(row.name); values != kTextValues.end()) return values->second;
  if (row.kind == SettingKind::choice) return {row.names.back(), row.names.front()};
  if (row.kind == SettingKind::count) return {std::to_string(row.max_count), std::to_string(row.min_count)};
  return {text_of(std::isfinite(row.max_number) ? row.max_number : 3), text_of(row.min_number)};
}

DrawSettings with_paths() {
  DrawSettings settings = default_settings();
  settings.path.emplace();
  return settings;
}

// Defaults that the row can change.
DrawSettings settings_for(const DrawSetting& row) {
  return row.needs_paths ? with_paths() : default_settings();
}

TEST(SettingTable, RowsRoundTrip) {
  for (const DrawSetting& row : draw_setting_table()) {
    SCOPED_TRACE(row.name);
    const Values values = values_of(row);
    for (const std::string& text : {values.first, values.second}) {
      DrawSettings settings = settings_for(row);
      EXPECT_EQ(row.set(text, settings), "");
      EXPECT_EQ(row.text(settings), text);
      if (row.is_preset) continue;  // other rows have its values
      DrawSettings copy = settings_for(row);
      row.copy(settings, copy);
      EXPECT_TRUE(row.is_same(settings, copy));
      EXPECT_EQ(row.text(copy), text);
    }
  }
}

TEST(SettingTable, RowsChangeNoOtherRow) {
  for (const DrawSetting& row : draw_setting_table()) {
    if (row.is_preset) continue;
    DrawSettings settings = settings_for(row);
    ASSERT_EQ(row.set(values_of(row).first, settings), "");
    for (const DrawSetting& other : draw_setting_table())
      EXPECT_EQ(other.is_same(settings, settings_for(row)), &other != &row) << row.name << ", " << other.name;
  }
}

TEST(SettingTable, DefaultsMatchDrawSettings) {
  const std::set<std::string> of_the_default_look{"background", "exposure", "tone-map"};
  for (const DrawSetting& row : draw_setting_table()) {
    EXPECT_EQ(row.is_same(DrawSettings(), default_settings()), !of_the_default_look.count(row.name))
        << row.name;
    if (row.kind != SettingKind::choice) continue;
    EXPECT_EQ(std::set<std::string>(row.names.begin(), row.names.end()).count(row.text(DrawSettings())), 1u);
  }
  EXPECT_EQ(draw_setting("exposure").text(default_settings()), "auto");
  EXPECT_EQ(draw_setting("tone-map").text(default_settings()), "neutral");
  EXPECT_EQ(draw_setting("background").text(default_settings()), "auto");
}

TEST(SettingTable, WindowsAndPagesHaveControls) {
  std::set<std::string> labels;
  for (const DrawSetting& row : draw_setting_table()) {
    SCOPED_TRACE(row.name);
    EXPECT_EQ(row.controls.empty(), !(row.users & (kByWindow | kByBrowser)));
    for (const SettingControl& control : row.controls) {
      SCOPED_TRACE(control.label);
      EXPECT_TRUE(labels.insert(control.label).second);
      DrawSettings settings = settings_for(row);
      EXPECT_EQ(control.names.size(), control.kind == ControlKind::choice ? control.values.size() : 0);
      std::vector<std::string> values = control.values;
      if (control.kind == ControlKind::color) values = {"20a0ff", "000000"};
      if (control.kind == ControlKind::slider) values = {text_of(control.least), text_of(control.most)};
      ASSERT_GE(values.size(), 2u);
      for (const std::string& value : values) {
        EXPECT_EQ(control.set(value, settings), "");
        EXPECT_EQ(control.text(settings), value);
      }
      EXPECT_NE(control.set("nonsense", settings), "");
      EXPECT_EQ(control.text(settings), values.back());
    }
  }
}

TEST(SettingTable, PathSettingsOutliveTheRaster) {
  DrawSettings settings;
  PathSettings paths;
  paths.bounces = 3;
  ASSERT_EQ(draw_setting("f-number").set("4", settings), "");
  ASSERT_EQ(draw_setting("render").set("path", settings), "");
  keep_path_settings(false, settings, paths);
  EXPECT_EQ(settings.path->bounces, 3u);
  EXPECT_EQ(settings.path->lens.f_number, 4);
  ASSERT_EQ(draw_setting("bounces").set("5", settings), "");
  keep_path_settings(true, settings, paths);
  ASSERT_EQ(draw_setting("render").set("raster", settings), "");
  keep_path_settings(true, settings, paths);
  EXPECT_EQ(paths.bounces, 5u);
}

TEST(SettingTable, InvalidValuesChangeNothing) {
  for (const DrawSetting& row : draw_setting_table()) {
    for (const char* text : {"", "nonsense", "nan", "inf", "-3000000"}) {
      DrawSettings settings = settings_for(row);
      EXPECT_NE(row.set(text, settings), "") << row.name << " " << text;
      EXPECT_EQ(compare(settings, settings_for(row)), Invalidates::nothing) << row.name << " " << text;
      EXPECT_TRUE(row.is_same(settings, settings_for(row))) << row.name << " " << text;
    }
  }
  DrawSettings settings;
  EXPECT_EQ(draw_setting("bloom").set("1.5", settings), "1.5 is not a number from 0 to 1");
  EXPECT_EQ(draw_setting("f-number").set("0", settings), "0 is not a number from 0.1 to 1000");
  EXPECT_EQ(draw_setting("focus-distance").set("x", settings), "x is not a number from 0.001 to 1000000");
  EXPECT_EQ(draw_setting("environment-intensity").set("-1", settings), "-1 is not a number above 0");
  EXPECT_EQ(draw_setting("environment-rotation").set("1e9", settings),
            "1e9 is not a number between -1000000 and 1000000");
  EXPECT_EQ(draw_setting("exposure").set("0", settings), "0 is not a number above 0, auto or metered");
  EXPECT_EQ(draw_setting("samples").set("65", settings), "65 is not a whole number from 1 to 64");
}

TEST(SettingTable, ChosenSettingsStayInMotion) {
  const auto in_motion = [](std::initializer_list<Values> chosen) {
    DrawSettings settings = default_settings();
    for (const auto& [name, value] : chosen) EXPECT_EQ(draw_setting(name).set(value, settings), "");
    return settings_in_motion(settings);
  };
  const auto reduced = in_motion({});
  ASSERT_TRUE(reduced);
  EXPECT_EQ(reduced->samples, 1u);
  EXPECT_EQ(reduced->shadows.method, ShadowMethod::map);
  EXPECT_EQ(in_motion({{"samples", "4"}})->samples, 4u) << "the default, but chosen";
  EXPECT_EQ(in_motion({{"samples", "4"}})->shadows.method, ShadowMethod::map);
  EXPECT_EQ(in_motion({{"shadows", "ray"}})->shadows.method, ShadowMethod::ray);
  EXPECT_EQ(in_motion({{"shadows", "off"}})->shadows.method, ShadowMethod::off);
  EXPECT_FALSE(in_motion({{"shadow-rays", "all"}})->shadows.hybrid);
  EXPECT_FALSE(in_motion({{"samples", "8"}, {"shadows", "map"}}));
  EXPECT_FALSE(in_motion({{"motion-quality", "full"}}));
  EXPECT_FALSE(in_motion({{"render", "path"}}));
}

TEST(SettingTable, NewRendererExactlyWhereDeclared) {
  for (const DrawSetting& row : draw_setting_table()) {
    const DrawSettings before = settings_for(row);
    DrawSettings after = before;
    ASSERT_EQ(row.set(values_of(row).first, after), "");
    EXPECT_EQ(compare(before, after), row.invalidates) << row.name;
    EXPECT_EQ(needs_new_renderer(before, after), row.invalidates == Invalidates::renderer) << row.name;
    if (row.is_preset) continue;
    DrawSettings applied = before;
    copy_applicable(after, applied);
    EXPECT_EQ(row.is_same(applied, after), row.invalidates != Invalidates::renderer) << row.name;
  }
}

TEST(SettingTable, EqualityMatchesUsers) {
  for (const DrawSetting& row : draw_setting_table()) {
    const DrawSettings before = settings_for(row);
    DrawSettings after = before;
    ASSERT_EQ(row.set(values_of(row).first, after), "");
    EXPECT_EQ(have_same_values(before, after, kByWindow), !(row.users & kByWindow)) << row.name;
    EXPECT_TRUE(have_same_values(before, before, 0xff)) << row.name;
  }
}

TEST(SettingTable, PresetsSetOtherRows) {
  const DrawSetting& preset = draw_setting("camera-preset");
  for (const bool traces : {false, true}) {
    DrawSettings settings = traces ? with_paths() : default_settings();
    const DrawSettings before = settings;
    ASSERT_EQ(preset.set("endoscope", settings), "");
    EXPECT_TRUE(settings.post.optics.any() && settings.post.metered && settings.lamps.count == 2);
    EXPECT_GT(settings.post.lens.f_number, 0);
    if (traces) {
      EXPECT_EQ(settings.path->lens.f_number, settings.post.lens.f_number);
    }
    // Each can be set by itself after it.
    ASSERT_EQ(draw_setting("fog").set("0.3", settings), "");
    EXPECT_EQ(settings.post.optics.fog, 0.3f);
    EXPECT_EQ(preset.text(settings), "none");
    ASSERT_EQ(preset.set("none", settings), "");
    EXPECT_EQ(compare(settings, before), Invalidates::nothing);
    EXPECT_FALSE(settings.post.optics.any());
  }
}

TEST(SettingTable, LensIsShared) {
  DrawSettings settings = with_paths();
  ASSERT_EQ(draw_setting("f-number").set("4", settings), "");
  EXPECT_EQ(settings.post.lens.f_number, 4);
  EXPECT_EQ(settings.path->lens.f_number, 4);
  ASSERT_EQ(draw_setting("shadows").set("ray-pipeline", settings), "");
  EXPECT_EQ(settings.shadows.back_end, RayBackEnd::pipeline);
  EXPECT_EQ(settings.ray_effects.back_end, RayBackEnd::pipeline);
  ASSERT_EQ(draw_setting("ray-effect-rays").set("9", settings), "");
  EXPECT_EQ(settings.ray_effects.occlusion_rays, 9u);
  EXPECT_EQ(settings.ray_effects.bounce_rays, 9u);
}

}  // namespace
}  // namespace fire3dv::settings
