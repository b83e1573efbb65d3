// Reading the blocks of ADF model and world files into objects.
#pragma once

#include <string>

#include "tools/convert/adf_objects.h"
#include "tools/convert/adf_visual.h"
#include "tools/convert/adf_yaml.h"

namespace fire3dv::convert {

struct AdfReading {
  AdfReport& report;
  AdfVisuals& visuals;
  AdfObjects& objects;
  std::string name_prefix;  // AMBF's --ns
};

// Both say whether there may be more objects still: false where one had to be left out.
// Bodies, soft bodies, ghost objects, cameras and lights.
bool read_adf_model(const AdfFile& file, AdfReading& reading);
// The lights and cameras of a world file. Its environment is a model, and comes before them.
bool read_adf_world(const AdfFile& file, AdfReading& reading);

}  // namespace fire3dv::convert
