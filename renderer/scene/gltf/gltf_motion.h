// Skins and animations of a glTF file, parsed directly from the JSON. tinygltf refuses skins without inverse
// bind matrices and channels without a node, both of which glTF allows.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "protocol/base/error.h"

namespace fire3dv::scene {

// Unchecked indices of the file; -1: missing.
struct SkinSource {
  std::string name;
  std::vector<int> joints;
  int inverse_bind_matrices = -1;
};

struct AnimationSource {
  struct Sampler {
    int input = -1, output = -1;
    std::string interpolation;
  };
  struct Channel {
    int sampler = -1, node = -1;
    std::string path;
  };
  std::string name;
  std::vector<Sampler> samplers;
  std::vector<Channel> channels;
};

// Moves skins and animations out of a document that passed check_and_reduce().
Result<void> take_motion(nlohmann::json& root, std::vector<SkinSource>& skins,
                         std::vector<AnimationSource>& animations);

}  // namespace fire3dv::scene
