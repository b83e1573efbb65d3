// Counts and distributions of the labels of a data set, and warnings that follow from them.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "renderer/dataset/labels/description.h"
#include "renderer/dataset/layouts/layout.h"
#include "renderer/offline/frame_format.h"

namespace fire3dv::dataset {

struct ObjectCounts {
  uint64_t labels = 0;             // in all images
  uint64_t images = 0;             // that show it
  uint64_t truncated = 0;          // labels of which a part is outside of the image
  double least_m = 0, most_m = 0;  // distance along the camera's axis
};

struct Histogram {
  std::string title, unit;
  std::vector<std::string> ranges;
  std::vector<uint64_t> counts;
};

struct Statistics {
  uint64_t images = 0, labels = 0, empty_images = 0;
  bool has_silhouettes = false;                              // with visible shares and truncated labels
  std::map<uint32_t, ObjectCounts> objects;                  // by Object::id
  std::map<std::string, std::array<uint64_t, 3>> keypoints;  // visible, hidden, outside
  std::vector<Histogram> histograms;
  std::vector<Histogram> drawn;       // of randomised parameters
  std::vector<std::string> warnings;  // also those of the scene
};

Statistics count(const Description& description, const Layout& layout, const offline::FrameLines& lines);

}  // namespace fire3dv::dataset
