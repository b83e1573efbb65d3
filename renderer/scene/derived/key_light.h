// Default key light: a directional light for scenes that bring no light of their own. It casts the shadows
// that an environment map alone does not give.
#pragma once

#include "renderer/scene/model/scene.h"

namespace fire3dv::scene {

// Illuminance of a surface that faces the light, in lux. With the studio environment, a white surface that
// faces upwards then has a radiance of about 1.
constexpr float kKeyLightLux = 1.7f;

// Appends a root node "key light" if the scene has no light. Derived data stay valid.
void add_key_light(Scene& scene);

// Removes what add_key_light() appended, if it is the last node.
void remove_key_light(Scene& scene);

}  // namespace fire3dv::scene
