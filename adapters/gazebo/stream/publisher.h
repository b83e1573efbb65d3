// Streams of a Gazebo world to one or more renderers: description, pose frames, added and removed assets,
// images of the first renderer. No call waits for a renderer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fire3dv/client.hpp>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"

namespace fire3dv::gazebo {

class Publisher {
 public:
  static Result<Publisher> open(const std::vector<std::string>& uris, const Security& security,
                                const std::string& name);

  // Starts a new epoch with these nodes.
  Result<void> describe(const std::vector<std::string>& node_names, const std::string& scene_uri);
  bool is_described() const { return is_described_; }
  // poses: 12 floats for each node, Z up. Values that a stream refuses are an error.
  Result<void> publish(int64_t sim_time_ns, const std::vector<float>& poses, bool is_discontinuity);

  // Adds the nodes of a .glb file below a new node of the root.
  Result<void> add_asset(const std::string& node, std::span<const std::byte> glb);
  // Ends add_asset() or remove_node() of this node.
  Result<void> undo(const std::string& node);
  Result<void> remove_node(const std::string& node);

  // Images of the newest frame, by the renderer of the first URI.
  Result<uint64_t> request_image(const fire3dv_image_request& request);
  // Returns the next image of the request, or null. The error is the renderer's refusal.
  Result<Image> take_image(uint64_t id);

  // New messages of renderers, each once. Call it regularly. expects_unknown_nodes: leaves out that nodes are
  // not in the renderer's scene.
  std::vector<std::string> poll(bool expects_unknown_nodes);

  struct Totals {
    std::string uri;
    uint64_t published = 0, dropped = 0;
  };
  std::vector<Totals> totals();

 private:
  struct Target {
    std::string uri;
    Stream stream;
    std::string message = {};  // last one that was reported
  };
  Result<void> for_each(const char* what, const std::function<void(Stream&)>& call);

  std::vector<Target> targets_;
  bool is_described_ = false;
};

}  // namespace fire3dv::gazebo
