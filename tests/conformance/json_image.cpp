#include "tests/conformance/json_image.h"

#include <nlohmann/json.hpp>

namespace fire3dv::conformance {
namespace {

using Json = nlohmann::ordered_json;

Json camera_to_json(const wire::Intrinsics& c) {
  Json json = {{"width", c.width},
               {"height", c.height},
               {"fx", c.fx},
               {"fy", c.fy},
               {"cx", c.cx},
               {"cy", c.cy},
               {"near_m", c.near_m},
               {"far_m", c.far_m},
               {"lens", static_cast<uint8_t>(c.lens.model)},
               {"lens_coefficients", c.lens.coefficients}};
  if (c.f_number != 0) json["f_number"] = c.f_number;  // since 1.7
  if (c.focus_distance_m != 0) json["focus_distance_m"] = c.focus_distance_m;
  return json;
}

wire::Intrinsics camera_from_json(const Json& json) {
  wire::Intrinsics c;
  json.at("width").get_to(c.width);
  json.at("height").get_to(c.height);
  json.at("fx").get_to(c.fx);
  json.at("fy").get_to(c.fy);
  json.at("cx").get_to(c.cx);
  json.at("cy").get_to(c.cy);
  json.at("near_m").get_to(c.near_m);
  json.at("far_m").get_to(c.far_m);
  c.lens.model = static_cast<wire::LensModel>(json.at("lens").get<uint8_t>());
  json.at("lens_coefficients").get_to(c.lens.coefficients);
  c.f_number = json.value("f_number", 0.0f);
  c.focus_distance_m = json.value("focus_distance_m", 0.0f);
  return c;
}

Json batch_to_json(const wire::ImageBatch& b) {
  Json poses = Json::array(), view_poses = Json::array(), projections = Json::array();
  for (const wire::Affine3x4& pose : b.poses) poses.push_back(pose.m);
  for (const wire::Affine3x4& pose : b.view_poses) view_poses.push_back(pose.m);
  for (const wire::Projection& p : b.view_projections) projections.push_back({p.fx, p.fy, p.cx, p.cy});
  return {{"worlds", b.worlds},       {"node_indices", b.node_indices},
          {"poses", poses},           {"world_of_view", b.world_of_view},
          {"view_poses", view_poses}, {"view_projections", projections},
          {"active", b.active}};
}

wire::ImageBatch batch_from_json(const Json& json) {
  wire::ImageBatch b;
  json.at("worlds").get_to(b.worlds);
  json.at("node_indices").get_to(b.node_indices);
  for (const Json& pose : json.at("poses")) pose.get_to(b.poses.emplace_back().m);
  json.at("world_of_view").get_to(b.world_of_view);
  for (const Json& pose : json.at("view_poses")) pose.get_to(b.view_poses.emplace_back().m);
  for (const Json& p : json.at("view_projections"))
    b.view_projections.push_back({p.at(0), p.at(1), p.at(2), p.at(3)});
  json.at("active").get_to(b.active);
  return b;
}

}  // namespace

Json image_to_json(const wire::ImageRequest& m) {
  Json json = {{"type", "ImageRequest"},
               {"epoch", m.epoch},
               {"id", m.id},
               {"place", m.place},
               {"node", m.node},
               {"parent_from_camera", m.parent_from_camera.m},
               {"camera", camera_to_json(m.intrinsics)},
               {"outputs", m.outputs},
               {"when", static_cast<uint8_t>(m.when)},
               {"every", m.every},
               {"rate_hz", m.rate_hz},
               {"sequence", m.sequence}};
  if (m.markers) json["markers"] = true;                 // since 1.6
  if (m.complete) json["complete"] = true;               // since 1.8
  if (m.batch) json["batch"] = batch_to_json(*m.batch);  // since 1.10
  return json;
}

Json image_to_json(const wire::ImageFrame& m) {
  Json planes = Json::array();
  for (const wire::ImagePlane& plane : m.planes)
    planes.push_back({{"output", plane.output_bit},
                      {"format", static_cast<uint8_t>(plane.format)},
                      {"width", plane.width},
                      {"height", plane.height},
                      {"row_stride", plane.row_stride},
                      {"offset", plane.offset},
                      {"bytes", plane.bytes}});
  Json json{{"type", "ImageFrame"},
            {"request", m.request},
            {"number", m.number},
            {"epoch", m.epoch},
            {"sequence", m.sequence},
            {"sim_time_ns", m.sim_time_ns},
            {"world_from_camera", m.world_from_camera.m},
            {"camera", camera_to_json(m.intrinsics)},
            {"pixel_bytes", m.pixel_bytes},
            {"planes", planes}};
  if (m.hidden_streams != 0) json["hidden_streams"] = m.hidden_streams;  // since 1.8
  if (m.views != 1) json["views"] = m.views;                             // since 1.10
  return json;
}

Json image_to_json(const wire::ImageRefused& m) {
  return {{"type", "ImageRefused"},
          {"epoch", m.epoch},
          {"request", m.request},
          {"reason", static_cast<uint8_t>(m.reason)},
          {"message", m.message}};
}

wire::Bytes encode_image_json(const Json& json) {
  const std::string type = json.at("type");
  if (type == "ImageRequest") {
    wire::ImageRequest m;
    json.at("epoch").get_to(m.epoch);
    json.at("id").get_to(m.id);
    json.at("place").get_to(m.place);
    json.at("node").get_to(m.node);
    json.at("parent_from_camera").get_to(m.parent_from_camera.m);
    m.intrinsics = camera_from_json(json.at("camera"));
    json.at("outputs").get_to(m.outputs);
    m.when = static_cast<wire::ImageWhen>(json.at("when").get<uint8_t>());
    json.at("every").get_to(m.every);
    json.at("rate_hz").get_to(m.rate_hz);
    json.at("sequence").get_to(m.sequence);
    m.markers = json.value("markers", false);
    m.complete = json.value("complete", false);
    if (json.contains("batch")) m.batch = batch_from_json(json.at("batch"));
    return wire::encode(m);
  }
  if (type == "ImageFrame") {
    wire::ImageFrame m;
    json.at("request").get_to(m.request);
    json.at("number").get_to(m.number);
    json.at("epoch").get_to(m.epoch);
    json.at("sequence").get_to(m.sequence);
    json.at("sim_time_ns").get_to(m.sim_time_ns);
    json.at("world_from_camera").get_to(m.world_from_camera.m);
    m.intrinsics = camera_from_json(json.at("camera"));
    m.hidden_streams = json.value("hidden_streams", 0u);
    m.views = json.value("views", 1u);
    json.at("pixel_bytes").get_to(m.pixel_bytes);
    for (const Json& plane : json.at("planes"))
      m.planes.push_back({plane.at("output"),
                          static_cast<wire::ImageFormat>(plane.at("format").get<uint8_t>()),
                          plane.at("width"), plane.at("height"), plane.at("row_stride"), plane.at("offset"),
                          plane.at("bytes")});
    return wire::encode(m);
  }
  if (type != "ImageRefused") return {};
  wire::ImageRefused m;
  json.at("epoch").get_to(m.epoch);
  json.at("request").get_to(m.request);
  m.reason = static_cast<wire::ImageRefusal>(json.at("reason").get<uint8_t>());
  json.at("message").get_to(m.message);
  return wire::encode(m);
}

}  // namespace fire3dv::conformance
