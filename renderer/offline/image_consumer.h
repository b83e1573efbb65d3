// Consumer of the images of an offline run, in place of its folder or video.
#pragma once

#include <cstdint>
#include <memory>

#include "base/error.h"
#include "renderer/offline/frame_format.h"
#include "renderer/offline/manifest.h"
#include "renderer/sinks/frame.h"
#include "renderer/sinks/run_provenance.h"

namespace fire3dv::offline {

class ImageConsumer : public sinks::FrameSink {
 public:
  // Once the inputs are read, before a device is opened. provenance: without the machine, which images have
  // (FrameImage::run_provenance). format: of a data set; else null. Returns false if nothing is to be drawn.
  virtual Result<bool> begin(const Manifest& manifest, const sinks::RunProvenance& provenance,
                             std::shared_ptr<FrameFormat> format) = 0;
  virtual bool is_wanted(uint64_t image) const = 0;
};

}  // namespace fire3dv::offline
