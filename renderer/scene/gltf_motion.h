// Skins and animations as the file has them, taken from the JSON by ourselves: tinygltf refuses skins without
// inverse bind matrices and channels without a node, both of which glTF allows.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "protocol/error.h"

namespace fire3dv::scene {

// Indices are of the file and not checked yet; -1 where the file has none.
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

// Moves them out of a document that check_and_reduce() has passed.
Result<void> take_motion(nlohmann::json& root, std::vector<SkinSource>& skins,
                         std::vector<AnimationSource>& animations);

}  // namespace fire3dv::scene
