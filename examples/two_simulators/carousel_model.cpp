#include "examples/two_simulators/carousel_model.h"

#include <mujoco/mujoco.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "examples/two_simulators/carousel.h"

namespace two_simulators {
namespace {

constexpr int kStepsEach = 2;  // MuJoCo steps per published step: light chains with heavy ends are stiff

std::string format(const char* pattern, auto... values) {
  char text[512];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

// MJCF text of a chain below the rotor, as nested bodies.
std::string chain_text(int chain, examples::Vec3 at) {
  std::string text, end;
  for (int link = 0; link < kLinks; ++link) {
    text +=
        format("<body name='%s' pos='%.6f %.6f %.6f'><joint type='ball' damping='1.5e-5' armature='1e-6'/>",
               link_name(chain, link).c_str(), static_cast<double>(at.x), static_cast<double>(at.y),
               static_cast<double>(at.z));
    text += format("<geom type='capsule' fromto='0 0 0 0 0 %.6f' size='%.6f' mass='0.003'/>",
                   static_cast<double>(-kLink_m), static_cast<double>(kLinkRadius_m));
    at = {0, 0, -kLink_m};
    end += "</body>";
  }
  text += format("<body name='%s' pos='0 0 %.6f'><joint type='ball' damping='4e-5' armature='1e-6'/>",
                 gondola_name(chain).c_str(), static_cast<double>(-kLink_m));
  // Unequal masses, so that the gondolas do not swing in phase.
  text += format(
      "<geom type='sphere' pos='0 0 %.6f' size='%.6f' mass='%.4f' contype='1' conaffinity='1'/></body>",
      static_cast<double>(-kGondolaRadius_m) - 0.006, static_cast<double>(kGondolaRadius_m),
      0.03 + 0.01 * chain);
  return text + end;
}

std::string model_text() {
  std::string text = format(
      "<mujoco model='carousel'><compiler angle='radian'/><option timestep='%.9f'/>"
      "<default><geom contype='0' conaffinity='0'/></default><worldbody>"
      "<body name='%s' pos='0 0 %.6f'><joint name='spin' type='hinge' axis='0 0 1' damping='0.0005'/>"
      "<geom type='cylinder' size='0.15 0.01' mass='0.6'/>",
      1 / (kStepsPerSecond * kStepsEach), kRotorName, static_cast<double>(kRotorZ_m));
  for (const CarouselBody& body : carousel_bodies()) {
    for (int chain = 0; chain < kChains; ++chain) {
      if (body.name == link_name(chain, 0))
        text += chain_text(chain, {body.at_m.x, body.at_m.y, body.at_m.z - kRotorZ_m});
    }
  }
  return text + "</body></worldbody><actuator><velocity joint='spin' kv='0.2'/></actuator></mujoco>";
}

// Temporary model file, since MuJoCo's functions for models in memory differ between versions.
struct ModelFile {
  ModelFile() {
    std::error_code failed;
    path = (std::filesystem::temp_directory_path(failed) / "two_simulators_XXXXXX.xml").string();
    const int file = ::mkstemps(path.data(), 4);
    if (file < 0) return;
    const std::string text = model_text();
    written = ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
    ::close(file);
  }
  ~ModelFile() { ::unlink(path.c_str()); }
  std::string path;
  bool written = false;
};

}  // namespace

struct CarouselModel::Model {
  ~Model() {
    mj_deleteData(data);
    mj_deleteModel(model);
  }
  mjModel* model = nullptr;
  mjData* data = nullptr;
  std::vector<int> body_ids;
};

std::unique_ptr<CarouselModel> CarouselModel::make(std::string* error) {
  const ModelFile file;
  if (!file.written) {
    *error = "cannot write " + file.path + ", which MuJoCo is to read: set TMPDIR to a folder of yours";
    return nullptr;
  }
  char reason[512] = "";
  auto model = std::make_unique<Model>();
  model->model = mj_loadXML(file.path.c_str(), nullptr, reason, sizeof reason);
  if (model->model == nullptr) {
    *error = "MuJoCo does not take the carousel: " + std::string(reason);
    return nullptr;
  }
  model->data = mj_makeData(model->model);
  mj_forward(model->model, model->data);
  for (const CarouselBody& body : carousel_bodies()) {
    model->body_ids.push_back(mj_name2id(model->model, mjOBJ_BODY, body.name.c_str()));
    if (model->body_ids.back() < 0) {
      *error = "MuJoCo's model has no body " + body.name;
      return nullptr;
    }
  }
  return std::unique_ptr<CarouselModel>(new CarouselModel(std::move(model)));
}

CarouselModel::CarouselModel(std::unique_ptr<Model> model) : model_(std::move(model)) {
  for (const CarouselBody& body : carousel_bodies()) names_.push_back(body.name);
  poses_.resize(names_.size() * 12);
  read_poses();
}

CarouselModel::~CarouselModel() = default;

bool CarouselModel::step() {
  constexpr double kMaxRadPerSecond = 6.4, kCycleSeconds = 18;
  for (int i = 0; i < kStepsEach; ++i) {
    const double turn = 2 * 3.14159265358979 * model_->data->time / kCycleSeconds;
    model_->data->ctrl[0] = kMaxRadPerSecond * (0.5 - 0.5 * std::cos(turn));
    mj_step(model_->model, model_->data);
  }
  mj_kinematics(model_->model, model_->data);  // mj_step leaves body poses of the step's start
  read_poses();
  return true;
}

void CarouselModel::read_poses() {
  float* out = poses_.data();
  for (const int body : model_->body_ids) {
    const mjtNum* place = model_->data->xpos + 3 * body;
    const mjtNum* turn = model_->data->xmat + 9 * body;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) *out++ = static_cast<float>(turn[3 * row + column]);
      *out++ = static_cast<float>(place[row]);
    }
  }
}

}  // namespace two_simulators
