#include "adapters/gazebo/stream/publisher.h"

#include <chrono>

#include "adapters/generic/call_client.h"
#include "protocol/wire/limits.h"

namespace fire3dv::gazebo {
namespace {

// Rotates Gazebo's Z up to glTF's Y up.
const std::vector<double> kWorldFromStream = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0};

}  // namespace

Result<Publisher> Publisher::open(const std::vector<std::string>& uris, const Security& security,
                                  const std::string& name) {
  Publisher publisher;
  for (const std::string& uri : uris) {
    const Result<void> opened = call_client("cannot publish to", uri, [&] {
      publisher.targets_.push_back({uri, Stream(uri, name, security, wire::kMaxSceneEditBytes)});
    });
    if (!opened) return opened.error();
  }
  return publisher;
}

Result<void> Publisher::for_each(const char* what, const std::function<void(Stream&)>& call) {
  for (Target& target : targets_) {
    const Result<void> done = call_client(what, target.uri, [&] { call(target.stream); });
    if (!done) return done;
  }
  return {};
}

Result<void> Publisher::describe(const std::vector<std::string>& node_names, const std::string& scene_uri) {
  Description description;
  description.node_names = node_names;
  description.world_from_stream = kWorldFromStream;
  description.scene_uri = scene_uri;
  is_described_ = true;
  return for_each("cannot describe the world to", [&](Stream& stream) { stream.describe(description); });
}

Result<void> Publisher::publish(int64_t sim_time_ns, const std::vector<float>& poses, bool is_discontinuity) {
  const uint32_t flags = is_discontinuity ? FIRE3DV_FRAME_DISCONTINUITY : 0;
  return for_each("cannot publish to", [&](Stream& stream) {
    stream.publish(std::chrono::nanoseconds(sim_time_ns), poses.data(), poses.size() / 12, flags);
  });
}

Result<void> Publisher::add_asset(const std::string& node, std::span<const std::byte> glb) {
  fire3dv_node added{};
  added.asset_glb = glb.data();
  added.asset_glb_bytes = glb.size();
  return for_each("cannot add a model to", [&](Stream& stream) { stream.add_node(node, added); });
}

Result<void> Publisher::undo(const std::string& node) {
  return for_each("cannot remove a model from",
                  [&](Stream& stream) { stream.clear(node, FIRE3DV_PROPERTY_NODE); });
}

Result<void> Publisher::remove_node(const std::string& node) {
  return for_each("cannot remove a model from", [&](Stream& stream) { stream.remove_node(node); });
}

Result<uint64_t> Publisher::request_image(const fire3dv_image_request& request) {
  uint64_t id = 0;
  const Result<void> requested = call_client("cannot request images of", targets_.front().uri,
                                             [&] { id = targets_.front().stream.request_image(request); });
  if (!requested) return requested.error();
  return id;
}

Result<Image> Publisher::take_image(uint64_t id) {
  Image image;
  const Result<void> taken = call_client("no images from", targets_.front().uri, [&] {
    image = targets_.front().stream.wait_image(id, std::chrono::milliseconds(0));
  });
  if (!taken) return taken.error();
  return image;
}

std::vector<std::string> Publisher::poll(bool expects_unknown_nodes) {
  std::vector<std::string> messages;
  for (Target& target : targets_) {
    const Result<void> polled = call_client("cannot poll", target.uri, [&] {
      const fire3dv_status status = target.stream.poll();
      if (status.welcome_message[0] == '\0' || target.message == status.welcome_message) return;
      target.message = status.welcome_message;
      if (expects_unknown_nodes && status.welcome == 0 && status.unmatched_names > 0) return;
      messages.push_back(target.uri + ": " + target.message);
    });
    if (!polled && target.message != polled.error().message) {
      target.message = polled.error().message;
      messages.push_back("warning: " + target.message);
    }
  }
  return messages;
}

std::vector<Publisher::Totals> Publisher::totals() {
  std::vector<Totals> totals;
  for (Target& target : targets_) {
    (void)call_client("cannot poll", target.uri, [&] {
      const fire3dv_status status = target.stream.poll();
      totals.push_back({target.uri, status.frames_published, status.frames_dropped});
    });
  }
  return totals;
}

}  // namespace fire3dv::gazebo
