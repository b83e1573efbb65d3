// MuJoCo simulation of the carousel: chains of ball joints and a motor of varying speed.
#pragma once

#include <memory>
#include <optional>

#include "examples/two_simulators/simulator.h"

namespace two_simulators {

class CarouselModel final : public Simulator {
 public:
  // Returns null and a message in *error when MuJoCo refuses the model.
  static std::unique_ptr<CarouselModel> make(std::string* error);
  ~CarouselModel() override;

  Frame frame() const override { return kCarouselFrame; }
  const std::vector<std::string>& names() const override { return names_; }
  const std::vector<float>& poses() const override { return poses_; }
  bool step() override;

 private:
  struct Model;
  explicit CarouselModel(std::unique_ptr<Model> model);
  void read_poses();

  std::unique_ptr<Model> model_;
  std::vector<std::string> names_;
  std::vector<float> poses_;
};

}  // namespace two_simulators
