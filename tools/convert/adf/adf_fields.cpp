#include "tools/convert/adf/adf_yaml.h"

#include <algorithm>
#include <array>

namespace fire3dv::convert {
namespace {

constexpr auto kFields = [] {
  std::array names = std::to_array<std::string_view>({
      // files
      "world config",
      "color config",
      "input devices config",
      "multibody configs",
      "plugins",
      "bodies",
      "soft bodies",
      "ghost objects",
      "vehicles",
      "volumes",
      "joints",
      "sensors",
      "actuators",
      "cameras",
      "lights",
      "high resolution path",
      "low resolution path",
      "namespace",
      "shaders",
      "gravity",
      "ignore inter-collision",
      "joint erp",
      "joint cfm",
      "environment",
      "enclosure",
      "skybox",
      "max iterations",
      "enclosure size",
      // bodies
      "name",
      "mesh",
      "mesh remove duplicates",
      "shape",
      "geometry",
      "compound shape",
      "scale",
      "location",
      "inertial offset",
      "use material",
      "color",
      "color rgba",
      "color components",
      "visible",
      "mass",
      "inertia",
      "collision margin",
      "collision groups",
      "collision mesh",
      "collision mesh type",
      "collision shape",
      "collision offset",
      "collision geometry",
      "compound collision shape",
      "controller",
      "controller output type",
      "damping",
      "friction",
      "restitution",
      "publish frequency",
      "publish children names",
      "publish joint names",
      "publish joint positions",
      "passive",
      "parent",
      "child",
      "config",
      "randomize constraints",
      "bending constraint",
      "cutting",
      "fixed nodes",
      "clusters",
      // cameras and lights
      "look at",
      "up",
      "clipping plane",
      "field view angle",
      "orthographic view width",
      "stereo",
      "controlling devices",
      "monitor",
      "publish image",
      "publish image interval",
      "publish image resolution",
      "publish depth",
      "publish depth interval",
      "publish depth resolution",
      "publish depth noise",
      "preprocessing shaders",
      "depth compute shaders",
      "multipass",
      "mouse control multipliers",
      "direction",
      "spot exponent",
      "shadow quality",
      "cutoff angle",
      "attenuation",
      // joints, as seen by the loader of vehicles and models
      "type",
      "chassis",
      "wheels",
  });
  std::sort(names.begin(), names.end());
  return names;
}();

}  // namespace

bool is_adf_field(std::string_view name) {
  return std::binary_search(kFields.begin(), kFields.end(), name);
}

}  // namespace fire3dv::convert
