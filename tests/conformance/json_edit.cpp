#include "tests/conformance/json_edit.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"

namespace fire3dv::conformance {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const wire::Cleared&) {
  return {{"type", "Cleared"}};
}
Json json_of(const wire::Visible& v) {
  return {{"type", "Visible"}, {"visible", v.visible}};
}
Json json_of(const wire::BaseColor& v) {
  return {{"type", "BaseColor"}, {"rgba", v.rgba}};
}
Json json_of(const wire::Light& v) {
  return {{"type", "Light"},
          {"kind", static_cast<uint8_t>(v.kind)},
          {"color_rgb", v.color_rgb},
          {"intensity", v.intensity},
          {"range_m", v.range_m},
          {"inner_cone_rad", v.inner_cone_rad},
          {"outer_cone_rad", v.outer_cone_rad},
          {"casts_shadow", v.casts_shadow}};
}
Json json_of(const wire::Camera& v) {
  Json json = {{"type", "Camera"},
               {"vertical_fov_rad", v.vertical_fov_rad},
               {"near_m", v.near_m},
               {"far_m", v.far_m},
               {"exposure", v.exposure}};
  if (v.f_number != 0) json["f_number"] = v.f_number;  // since 1.7
  if (v.focus_distance_m != 0) json["focus_distance_m"] = v.focus_distance_m;
  return json;
}
Json json_of(const wire::NodeAdded& v) {
  Json glb = Json::array();
  for (const std::byte byte : v.asset_glb) glb.push_back(static_cast<uint8_t>(byte));
  return {{"type", "NodeAdded"},      {"parent", v.parent}, {"parent_from_node", v.parent_from_node.m},
          {"asset_uri", v.asset_uri}, {"asset_glb", glb},   {"variant", v.variant}};
}
Json json_of(const wire::NodeRemoved&) {
  return {{"type", "NodeRemoved"}};
}
Json json_of(const wire::Vertices& v) {
  return {{"type", "Vertices"}, {"positions", v.positions}, {"normals", v.normals}};
}
Json json_of(const wire::Marker& v) {
  Json json = {{"type", "Marker"},
               {"kind", static_cast<uint8_t>(v.kind)},
               {"width_unit", static_cast<uint8_t>(v.width_unit)},
               {"flags", v.flags},
               {"width", v.width},
               {"lifetime_ns", v.lifetime_ns},
               {"sim_time_ns", v.sim_time_ns},
               {"parent", v.parent},
               {"parent_from_marker", v.parent_from_marker.m},
               {"positions", v.positions},
               {"rotations", v.rotations},
               {"sizes", v.sizes},
               {"colors", v.colors}};
  if (!v.texts.empty()) json["texts"] = v.texts;  // since 1.5
  if (v.image != wire::MarkerImage{})             // since 1.6
    json["image"] = {{"width", v.image.width},
                     {"height", v.image.height},
                     {"channels", v.image.channels},
                     {"pixels", v.image.pixels}};
  return json;
}
Json json_of(const wire::Scalars& v) {
  return {{"type", "Scalars"}, {"names", v.names}, {"units", v.units}};
}
Json json_of(const wire::ScalarValues& v) {
  Json values = Json::array();
  for (const double value : v.values) values.push_back(std::isnan(value) ? Json() : Json(value));
  return {{"type", "ScalarValues"},
          {"declaration", v.declaration},
          {"sim_time_ns", v.sim_time_ns},
          {"values", values}};
}

Json json_of(const wire::Input& v) {
  return {{"type", "Input"},      {"kind", static_cast<uint8_t>(v.kind)},
          {"flags", v.flags},     {"minimum", v.minimum},
          {"maximum", v.maximum}, {"step", v.step},
          {"value", v.value},     {"speed", v.speed},
          {"unit", v.unit},       {"text", v.text},
          {"choices", v.choices}};
}

}  // namespace

Json value_to_json(const wire::EditValue& value) {
  return std::visit([](const auto& v) { return json_of(v); }, value);
}

wire::EditValue value_from_json(const Json& json) {
  const std::string type = json.at("type");
  if (type == "Cleared") return wire::Cleared{};
  if (type == "Visible") return wire::Visible{json.at("visible")};
  if (type == "BaseColor") return wire::BaseColor{json.at("rgba").get<std::array<float, 4>>()};
  if (type == "Light") {
    wire::Light v;
    v.kind = static_cast<wire::LightKind>(json.at("kind").get<uint8_t>());
    json.at("color_rgb").get_to(v.color_rgb);
    json.at("intensity").get_to(v.intensity);
    json.at("range_m").get_to(v.range_m);
    json.at("inner_cone_rad").get_to(v.inner_cone_rad);
    json.at("outer_cone_rad").get_to(v.outer_cone_rad);
    json.at("casts_shadow").get_to(v.casts_shadow);
    return v;
  }
  if (type == "Camera") {
    return wire::Camera{json.at("vertical_fov_rad"),
                        json.at("near_m"),
                        json.at("far_m"),
                        json.at("exposure"),
                        json.value("f_number", 0.0f),
                        json.value("focus_distance_m", 0.0f)};
  }
  if (type == "NodeAdded") {
    wire::NodeAdded v;
    json.at("parent").get_to(v.parent);
    json.at("parent_from_node").get_to(v.parent_from_node.m);
    json.at("asset_uri").get_to(v.asset_uri);
    for (const Json& byte : json.at("asset_glb")) v.asset_glb.push_back(std::byte{byte.get<uint8_t>()});
    json.at("variant").get_to(v.variant);
    return v;
  }
  if (type == "NodeRemoved") return wire::NodeRemoved{};
  if (type == "Marker") {
    wire::Marker v;
    v.kind = static_cast<wire::MarkerKind>(json.at("kind").get<uint8_t>());
    v.width_unit = static_cast<wire::MarkerUnit>(json.at("width_unit").get<uint8_t>());
    json.at("flags").get_to(v.flags);
    json.at("width").get_to(v.width);
    json.at("lifetime_ns").get_to(v.lifetime_ns);
    json.at("sim_time_ns").get_to(v.sim_time_ns);
    json.at("parent").get_to(v.parent);
    json.at("parent_from_marker").get_to(v.parent_from_marker.m);
    json.at("positions").get_to(v.positions);
    json.at("rotations").get_to(v.rotations);
    json.at("sizes").get_to(v.sizes);
    json.at("colors").get_to(v.colors);
    if (json.contains("texts")) json.at("texts").get_to(v.texts);
    if (json.contains("image")) {
      const Json& image = json.at("image");
      v.image = {image.at("width"), image.at("height"), image.at("channels"), image.at("pixels")};
    }
    return v;
  }
  if (type == "Scalars") return wire::Scalars{json.at("names"), json.at("units")};
  if (type == "ScalarValues") {
    wire::ScalarValues v;
    json.at("declaration").get_to(v.declaration);
    json.at("sim_time_ns").get_to(v.sim_time_ns);
    for (const Json& value : json.at("values"))
      v.values.push_back(value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>());
    return v;
  }
  if (type == "Input") {
    wire::Input v;
    v.kind = static_cast<wire::InputKind>(json.at("kind").get<uint8_t>());
    json.at("flags").get_to(v.flags);
    json.at("minimum").get_to(v.minimum);
    json.at("maximum").get_to(v.maximum);
    json.at("step").get_to(v.step);
    json.at("value").get_to(v.value);
    json.at("speed").get_to(v.speed);
    json.at("unit").get_to(v.unit);
    json.at("text").get_to(v.text);
    json.at("choices").get_to(v.choices);
    return v;
  }
  FIRE3DV_ASSERT(type == "Vertices");
  wire::Vertices v;
  json.at("positions").get_to(v.positions);
  json.at("normals").get_to(v.normals);
  return v;
}

}  // namespace fire3dv::conformance
