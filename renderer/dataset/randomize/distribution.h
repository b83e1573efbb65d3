// Distributions of parameters and their draws. A draw is a hash of seed, frame and the parameter's name: it
// depends on no other draw and on no order, so that shards and continued runs draw the same values.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace fire3dv::dataset {

struct Distribution {
  enum class Kind : uint8_t { constant, uniform, log_uniform, normal, elevation, choice };
  Kind kind = Kind::constant;
  // constant: low. normal: mean and standard deviation. elevation: degrees, even over the area of a sphere.
  double low = 0, high = 0;
  std::vector<double> choices;
  double least = 0, most = 0;  // normal: draws beyond are moved to these limits
};

struct VectorDistribution {
  std::array<Distribution, 3> parts;
  std::vector<glm::dvec3> choices;  // not empty: instead of the parts
};

// Value of a drawn parameter: one number, three of a vector, four (x, y, z, w) of a rotation, or a text.
struct DrawnValue {
  std::vector<double> numbers;
  std::string text;  // without numbers
  bool operator==(const DrawnValue&) const = default;
};
// Drawn parameters of an image.
using DrawnValues = std::vector<std::pair<std::string, DrawnValue>>;

// Random numbers of one parameter of one frame.
class ParameterDraw {
 public:
  ParameterDraw(uint64_t seed, uint64_t frame, std::string_view parameter);

  uint64_t next();
  double unit();  // in [0, 1)
  double number(const Distribution& of);
  glm::dvec3 vector(const VectorDistribution& of);
  glm::dquat rotation();  // uniform over all rotations
  size_t index(size_t count) { return static_cast<size_t>(next() % count); }

 private:
  uint64_t state_;
};

// Adds noise to the sRGB colours of an image: independent, close to normal (a sum of four uniform numbers),
// with this standard deviation in steps of a channel. Alpha stays.
void add_noise(std::vector<uint8_t>& rgba8, double deviation, uint64_t seed, uint64_t image);

}  // namespace fire3dv::dataset
