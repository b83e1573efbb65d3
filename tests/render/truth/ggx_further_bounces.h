// Further bounces of a white GGX metal by the formula of docs/design/materials.md (Kulla and Conty 2017),
// with albedos by quadrature: (1 - E(n.v)) (1 - E(n.l)) / (pi (1 - mean E)).
#pragma once

#include <array>
#include <cmath>

namespace fire3dv::test {

class GgxFurtherBounces {
 public:
  explicit GgxFurtherBounces(double roughness) : alpha_(roughness * roughness) {
    for (int i = 0; i < kCosines; ++i) albedo_[static_cast<size_t>(i)] = albedo((i + 0.5) / kCosines);
    double mean = 0;
    for (int i = 0; i < kCosines; ++i)
      mean += 2 * albedo_[static_cast<size_t>(i)] * (i + 0.5) / (kCosines * kCosines);
    mean_ = mean;
  }

  double brdf(double cos_view, double cos_light) const {
    return (1 - at(cos_view)) * (1 - at(cos_light)) / (kPi * (1 - mean_));
  }
  double at(double cosine) const {
    const double place = std::fmin(std::fmax(cosine * kCosines - 0.5, 0), kCosines - 1.001);
    const auto low = static_cast<size_t>(place);
    const double share = place - static_cast<double>(low);
    return (1 - share) * albedo_[low] + share * albedo_[low + 1];
  }

 private:
  static constexpr int kCosines = 128, kPolar = 256, kAround = 128;
  static constexpr double kPi = 3.14159265358979;

  // Share of light that one bounce reflects: the integral over half vectors h of D(h) (n.h), of which
  // 4 (v.h) F V (n.l) is reflected; with F = 1 and height-correlated Smith. The half vectors are spaced by
  // their distribution, so that D(h) (n.h) is uniform.
  double albedo(double cos_view) const {
    const double sin_view = std::sqrt(1 - cos_view * cos_view), a2 = alpha_ * alpha_;
    double sum = 0;
    for (int i = 0; i < kPolar; ++i) {
      const double u = (i + 0.5) / kPolar;
      const double cos_half = std::sqrt((1 - u) / (1 + (a2 - 1) * u));
      const double sin_half = std::sqrt(1 - cos_half * cos_half);
      for (int k = 0; k < kAround; ++k) {
        const double view_half =
            sin_view * sin_half * std::cos(2 * kPi * (k + 0.5) / kAround) + cos_view * cos_half;
        const double cos_light = 2 * view_half * cos_half - cos_view;
        if (view_half <= 0 || cos_light <= 0) continue;
        const auto smith = [a2](double c, double other) { return other * std::sqrt(c * c * (1 - a2) + a2); };
        const double visibility = 0.5 / (smith(cos_view, cos_light) + smith(cos_light, cos_view));
        sum += 4 * view_half * visibility * cos_light / cos_half;
      }
    }
    return sum / (kPolar * kAround);
  }

  double alpha_, mean_ = 0;
  std::array<double, kCosines> albedo_{};
};

}  // namespace fire3dv::test
