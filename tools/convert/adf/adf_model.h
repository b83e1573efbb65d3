// Reader for blocks of ADF model and world files. It appends objects in AMBF's creation order.
#pragma once

#include <string>

#include "tools/convert/adf/adf_objects.h"
#include "tools/convert/adf/adf_visual.h"
#include "tools/convert/adf/adf_yaml.h"

namespace fire3dv::convert {

struct AdfReading {
  AdfReport& report;
  AdfVisuals& visuals;
  AdfObjects& objects;
  std::string name_prefix;  // AMBF's --ns
};

// Both return false when an object was skipped for lack of room.
// Reads bodies, soft bodies, ghost objects, cameras and lights.
bool read_adf_model(const AdfFile& file, AdfReading& reading);
// Reads lights and cameras of a world file. Its environment is a model file and must be read first.
bool read_adf_world(const AdfFile& file, AdfReading& reading);

}  // namespace fire3dv::convert
