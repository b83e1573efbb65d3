// C++17 API of the FIRE-3DV client library: the C API of client.h with RAII, containers and exceptions.
// Header only; link with fire3dv-client. Units, frames, thread-safety, blocking and allocation: see client.h.
//
//   fire3dv::Stream stream("shm://demo", "my simulator");
//   stream.describe({"base", "arm"});
//   loop { step(); stream.publish(sim_time, poses); }   // poses: std::vector<fire3dv::Pose>
//
// Errors: failures throw fire3dv::ClientError. A missing renderer is not an error.
#ifndef FIRE3DV_CLIENT_HPP
#define FIRE3DV_CLIENT_HPP

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "fire3dv/client.h"
#include "fire3dv/image.h"
#include "fire3dv/scene.h"

namespace fire3dv {

// stream_from_body: 3x4 matrix, row-major. publish() reads a contiguous container of poses in place.
using Pose = std::array<float, 12>;
static_assert(sizeof(Pose) == 48, "poses must lie in memory one after the other");

// Error of a call: what() is the message of fire3dv_last_error, code() a FIRE3DV_ERROR_* value. All failures
// of the Stream constructor have the code FIRE3DV_ERROR_ARGUMENT.
class ClientError : public std::runtime_error {
 public:
  ClientError(int code, const std::string& sentence) : std::runtime_error(sentence), code_(code) {}
  int code() const noexcept { return code_; }

 private:
  int code_;
};

// Stream description: node names, frames and rate. Empty members select the default.
struct Description {
  std::vector<std::string> node_names;
  std::vector<double> world_from_stream;  // 12 doubles, row-major; empty: identity
  std::vector<Pose> body_from_node;       // none, one for all nodes, or one per node
  double nominal_rate_hz = 0;             // hertz; 0: unknown
  std::string scene_uri;                  // informative, for users and recordings
};

// Paths of key and certificate files, never key material itself. Empty: none. client.h lists which link reads
// which file.
struct Security {
  std::string key_file;
  std::string tls_ca_file;
  std::string tls_certificate_file;
  std::string tls_key_file;
};

// Owning handle of a borrowed image; null when empty. Its destructor releases the image, on any thread, even
// after the stream is closed.
struct ReleaseImage {
  void operator()(fire3dv_image* image) const noexcept { fire3dv_release_image(&image); }
};
using Image = std::unique_ptr<fire3dv_image, ReleaseImage>;

// Returns the plane of one FIRE3DV_IMAGE_* output, or null. The image owns the plane.
inline const fire3dv_image_plane* plane_of(const fire3dv_image& image, uint32_t output) noexcept {
  return fire3dv_plane_of(&image, output);
}

// Owner of a stream; movable, not copyable. Any thread may use it, but not while it is moved or destroyed.
class Stream {
 public:
  // uri: "shm://NAME", "tcp://HOST:PORT", "tls://HOST:PORT" or "udp://HOST:PORT". scene_budget_bytes: limit
  // of all encoded scene edits (fire3dv/scene.h); 0: the default.
  explicit Stream(const std::string& uri, const std::string& adapter_name = {}, const Security& security = {},
                  std::size_t scene_budget_bytes = 0) {
    fire3dv_options options{};
    options.struct_size = sizeof options;
    if (!adapter_name.empty()) options.adapter_name = adapter_name.c_str();
    const auto file = [](const std::string& name) { return name.empty() ? nullptr : name.c_str(); };
    options.key_file = file(security.key_file);
    options.tls_ca_file = file(security.tls_ca_file);
    options.tls_certificate_file = file(security.tls_certificate_file);
    options.tls_key_file = file(security.tls_key_file);
    options.scene_budget_bytes = scene_budget_bytes;
    stream_ = fire3dv_open(uri.c_str(), &options);
    if (!stream_) throw ClientError(FIRE3DV_ERROR_ARGUMENT, fire3dv_last_error());
  }
  ~Stream() { fire3dv_close(&stream_); }
  Stream(Stream&& other) noexcept : stream_(std::exchange(other.stream_, nullptr)) {}
  Stream& operator=(Stream&& other) noexcept {
    std::swap(stream_, other.stream_);
    return *this;
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  // Sets the nodes that poses move and starts a new epoch. Call it again when bodies are added or removed.
  void describe(const Description& description) {
    const auto& matrix = description.world_from_stream;
    if (!matrix.empty() && matrix.size() != 12) {
      throw ClientError(FIRE3DV_ERROR_ARGUMENT, "world_from_stream must be empty or hold 12 numbers");
    }
    std::vector<const char*> names;
    names.reserve(description.node_names.size());
    for (const std::string& name : description.node_names) {
      if (name.find('\0') != std::string::npos) {
        throw ClientError(FIRE3DV_ERROR_ARGUMENT,
                          "node_names[" + std::to_string(names.size()) + "] holds a NUL");
      }
      names.push_back(name.c_str());
    }
    fire3dv_description raw{};
    raw.struct_size = sizeof raw;
    raw.node_names = names.data();
    raw.node_count = names.size();
    raw.world_from_stream = matrix.empty() ? nullptr : matrix.data();
    raw.body_from_node =
        description.body_from_node.empty() ? nullptr : description.body_from_node.front().data();
    raw.body_from_node_count = description.body_from_node.size();
    raw.nominal_rate_hz = description.nominal_rate_hz;
    raw.scene_uri = description.scene_uri.empty() ? nullptr : description.scene_uri.c_str();
    check(fire3dv_describe(stream_, &raw));
  }
  void describe(std::vector<std::string> node_names) {
    Description description;
    description.node_names = std::move(node_names);
    describe(description);
  }

  // Publishes one pose per described node, in the order of description. flags: FIRE3DV_FRAME_* bits.
  void publish(std::chrono::nanoseconds sim_time, const std::vector<Pose>& stream_from_body,
               uint32_t flags = 0) {
    const float* first = stream_from_body.empty() ? nullptr : stream_from_body.front().data();
    publish(sim_time, first, stream_from_body.size(), flags);
  }
  // Same for any array of pose_count times 12 floats.
  void publish(std::chrono::nanoseconds sim_time, const float* stream_from_body, std::size_t pose_count,
               uint32_t flags = 0) {
    check(fire3dv_publish(stream_, sim_time.count(), stream_from_body, pose_count, flags));
  }

  // Publishes poses of these nodes only, with increasing indices. The first call after describe() must name
  // all nodes.
  void publish_some(std::chrono::nanoseconds sim_time, const std::vector<uint32_t>& node_indices,
                    const std::vector<Pose>& stream_from_body, uint32_t flags = 0) {
    if (node_indices.size() != stream_from_body.size())
      throw ClientError(FIRE3DV_ERROR_ARGUMENT, "node_indices and stream_from_body must be of one length");
    const float* first = stream_from_body.empty() ? nullptr : stream_from_body.front().data();
    check(fire3dv_publish_some(stream_, sim_time.count(), node_indices.data(), first, node_indices.size(),
                               flags));
  }

  // Scene edits, defined in fire3dv/scene.h. The caller need not set struct_size.
  void set_visible(const std::string& node, bool visible) {
    check(fire3dv_set_visible(stream_, name_of(node), visible));
  }
  void set_base_color(const std::string& node, const std::array<float, 4>& rgba) {
    check(fire3dv_set_base_color(stream_, name_of(node), rgba.data()));
  }
  void set_light(const std::string& node, fire3dv_light light) {
    light.struct_size = sizeof light;
    check(fire3dv_set_light(stream_, name_of(node), &light));
  }
  void set_camera(const std::string& node, fire3dv_camera camera) {
    camera.struct_size = sizeof camera;
    check(fire3dv_set_camera(stream_, name_of(node), &camera));
  }
  void add_node(const std::string& node, fire3dv_node added = {}) {
    added.struct_size = sizeof added;
    check(fire3dv_add_node(stream_, name_of(node), &added));
  }
  void remove_node(const std::string& node) { check(fire3dv_remove_node(stream_, name_of(node))); }
  // normals: empty, or as many as positions.
  void set_vertices(const std::string& node, const std::vector<std::array<float, 3>>& positions,
                    const std::vector<std::array<float, 3>>& normals = {}) {
    if (!normals.empty() && normals.size() != positions.size())
      throw ClientError(FIRE3DV_ERROR_ARGUMENT, "normals must be none, or as many as positions");
    fire3dv_vertices vertices{};
    vertices.struct_size = sizeof vertices;
    vertices.positions = positions.empty() ? nullptr : positions.front().data();
    vertices.normals = normals.empty() ? nullptr : normals.front().data();
    vertices.vertex_count = positions.size();
    check(fire3dv_set_vertices(stream_, name_of(node), &vertices));
  }
  // property: FIRE3DV_PROPERTY_*.
  void clear(const std::string& node, int property) {
    check(fire3dv_clear(stream_, name_of(node), property));
  }

  // Processes renderers' messages. Never blocks.
  fire3dv_status poll() {
    fire3dv_status status{};
    status.struct_size = sizeof status;
    check(fire3dv_poll(stream_, &status));
    return status;
  }

  // Lockstep: returns true when a renderer has shown this frame, false after the timeout.
  bool wait_ack(uint64_t sequence, std::chrono::milliseconds timeout) {
    const auto milliseconds = std::clamp<std::chrono::milliseconds::rep>(timeout.count(), 0, UINT32_MAX);
    const int code = fire3dv_wait_ack(stream_, sequence, static_cast<uint32_t>(milliseconds));
    if (code == FIRE3DV_ERROR_TIMEOUT) return false;
    check(code);
    return true;
  }

  // Image requests, defined in fire3dv/image.h. The caller need not set struct_size. Returns the request id.
  uint64_t request_image(fire3dv_image_request request) {
    request.struct_size = sizeof request;
    uint64_t id = 0;
    check(fire3dv_request_image(stream_, &request, &id));
    return id;
  }
  void cancel_image(uint64_t id) { check(fire3dv_cancel_image(stream_, id)); }
  // Returns the next image of the request, or of any request with id 0. Empty after the timeout; throws on
  // refusal.
  Image wait_image(uint64_t id, std::chrono::milliseconds timeout) {
    const auto most = static_cast<std::chrono::milliseconds::rep>(UINT32_MAX);
    fire3dv_image* image = nullptr;
    const int code = fire3dv_wait_image(
        stream_, id, static_cast<uint32_t>(std::min(std::max<decltype(most)>(timeout.count(), 0), most)),
        &image);
    if (code != FIRE3DV_ERROR_TIMEOUT) check(code);
    return Image(image);
  }

  // Returns the C handle, for functions without a wrapper. The Stream keeps ownership.
  fire3dv_stream* get() const noexcept { return stream_; }

 private:
  static const char* name_of(const std::string& node) {
    if (node.find('\0') != std::string::npos)
      throw ClientError(FIRE3DV_ERROR_ARGUMENT, "the name of a node holds a NUL");
    return node.c_str();
  }
  static void check(int code) {
    if (code != FIRE3DV_OK) throw ClientError(code, fire3dv_last_error());
  }

  fire3dv_stream* stream_ = nullptr;
};

}  // namespace fire3dv

#endif
