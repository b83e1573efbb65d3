// Lockstep client for one camera of a model: publishes a frame and returns the renderer's image of it. One
// thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "adapters/mujoco/compare/labels.h"
#include "adapters/mujoco/publisher.h"
#include "adapters/mujoco/simulation.h"

namespace fire3dv::mujoco {

class RequestedImages {
 public:
  static Result<RequestedImages> open(const Simulation& simulation, const std::string& uri,
                                      const ImageSpec& spec, double timeout_s);

  // Publishes mjData unchanged and waits for its image.
  Result<Image> draw(const Simulation& simulation);
  Result<LabelledDepth> labelled(const fire3dv_image& image) const;
  static std::vector<uint8_t> rgb(const fire3dv_image& image);

 private:
  RequestedImages(Publisher publisher, InstanceLabels labels, uint64_t request, double timeout_s)
      : publisher_(std::move(publisher)),
        labels_(std::move(labels)),
        request_(request),
        timeout_s_(timeout_s) {}

  Publisher publisher_;
  InstanceLabels labels_;
  uint64_t request_;
  double timeout_s_;
};

}  // namespace fire3dv::mujoco
