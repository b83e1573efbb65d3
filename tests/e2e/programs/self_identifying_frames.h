// Self-identifying pose frames: each number encodes run, frame, node and element. A reader detects a frame
// with any number of another frame, node or run of the simulator.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fire3dv/client.h"
#include "protocol/wire/messages.h"

namespace fire3dv::test {

// Integers below 2^24, which floats represent exactly.
inline float frame_value(uint64_t run, uint64_t sequence, size_t node, size_t element) {
  uint64_t mixed = run * 0x9e3779b97f4a7c15 + sequence * 0xbf58476d1ce4e5b9 + node * 12 + element;
  mixed = (mixed ^ (mixed >> 30)) * 0x94d049bb133111eb;
  return static_cast<float>((mixed ^ (mixed >> 31)) >> 40);
}

inline void tell(uint64_t run, uint64_t sequence, std::span<wire::Affine3x4> poses) {
  for (size_t node = 0; node < poses.size(); ++node)
    for (size_t element = 0; element < 12; ++element)
      poses[node].m[element] = frame_value(run, sequence, node, element);
}

inline bool tells(uint64_t run, uint64_t sequence, size_t first_node,
                  std::span<const wire::Affine3x4> poses) {
  for (size_t node = 0; node < poses.size(); ++node)
    for (size_t element = 0; element < 12; ++element)
      if (poses[node].m[element] != frame_value(run, sequence, first_node + node, element)) return false;
  return true;
}

// Publisher of such frames. The adapter's name contains the run.
class SelfIdentifyingPublisher {
 public:
  SelfIdentifyingPublisher(const std::string& uri, uint64_t run, size_t nodes) : run_(run), poses_(nodes) {
    const std::string name = "run " + std::to_string(run);
    fire3dv_options options{};
    options.struct_size = sizeof options;
    options.adapter_name = name.c_str();
    stream_ = fire3dv_open(uri.c_str(), &options);
    std::vector<std::string> names(nodes);
    std::vector<const char*> pointers(nodes);
    for (size_t node = 0; node < nodes; ++node) {
      names[node] = "node " + std::to_string(node);
      pointers[node] = names[node].c_str();
    }
    fire3dv_description description{};
    description.struct_size = sizeof description;
    description.node_names = pointers.data();
    description.node_count = nodes;
    good_ = stream_ != nullptr && fire3dv_describe(stream_, &description) == FIRE3DV_OK;
  }
  ~SelfIdentifyingPublisher() { fire3dv_close(&stream_); }
  SelfIdentifyingPublisher(const SelfIdentifyingPublisher&) = delete;
  SelfIdentifyingPublisher& operator=(const SelfIdentifyingPublisher&) = delete;

  bool good() const { return good_; }
  uint64_t published() const { return sequence_; }

  bool publish(int64_t sim_time_ns) {
    tell(run_, ++sequence_, poses_);
    return fire3dv_publish(stream_, sim_time_ns, poses_.front().m.data(), poses_.size(), 0) == FIRE3DV_OK;
  }
  fire3dv_status poll() {
    fire3dv_status status{};
    status.struct_size = sizeof status;
    fire3dv_poll(stream_, &status);
    return status;
  }

 private:
  uint64_t run_;
  std::vector<wire::Affine3x4> poses_;
  fire3dv_stream* stream_ = nullptr;
  bool good_ = false;
  uint64_t sequence_ = 0;
};

}  // namespace fire3dv::test
