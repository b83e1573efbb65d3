// Randomisation of the images of a data set: draws the parameters of a plan and applies them to edits,
// settings and cameras. Parameters of the scene are drawn for each frame, and are the same for all its
// cameras; those of cameras for each image. Single-threaded.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/dataset/randomize/plan.h"
#include "renderer/dataset/randomize/settle_shapes.h"
#include "renderer/offline/image_changes.h"

namespace fire3dv::dataset {

class Randomizer final : public offline::ImageChanges {
 public:
  // cameras: titles of the cameras of a frame, in order. plan: borrowed.
  Randomizer(const Plan& plan, const std::vector<std::string>& cameras);

  // Names that match nothing. Nodes that streams add are not known yet.
  struct Unmatched {
    std::string text;  // names file and line
    bool is_pattern = false;
  };
  static std::vector<Unmatched> unmatched(const Plan& plan, const scene::Scene& scene,
                                          const std::vector<std::string>& cameras);

  Result<void> set_scene(const scene::Scene& scene, const settings::DrawSettings& settings) override;
  Result<void> change_frame(uint64_t frame, state::UserEdits& edits,
                            settings::DrawSettings& settings) override;
  Result<bool> add_transforms(const state::PoseState& poses, state::NodeTransforms& transforms) override;
  void change_camera(uint64_t image, const state::PoseState& poses, app::CameraRig::Placed& camera) override;
  bool has_lens() const override;

  // Draws of the image of the last change_camera(), those of its frame first.
  DrawnValues drawn() const;
  double noise() const { return noise_; }  // of that image; 0: none

 private:
  // Object of a section with the fields of all patterns that match it; later patterns replace earlier ones.
  struct Object {
    uint32_t index = 0;
    std::string title;
    Entry fields;
  };
  // Draws of one object, each added to a record.
  class Draws;

  static std::vector<Object> match(const Plan& plan, Section section, const std::vector<std::string>& names,
                                   const std::vector<std::string>& paths);
  void change_node(const Object& object, state::UserEdits& edits);
  void change_distractors(state::UserEdits& edits);
  // Draws the place of a node. before: its transform.
  void place_node(const Object& object, Draws& draws, const glm::dmat4& before, state::UserEdits& edits);
  Result<bool> settle_nodes(const state::PoseState& poses, state::NodeTransforms& transforms);
  bool place_lights(const state::PoseState& poses, state::NodeTransforms& transforms);
  void change_material(const Object& object, state::UserEdits& edits);
  void change_light(const Object& object, state::UserEdits& edits);
  Result<void> change_settings(settings::DrawSettings& settings);
  Result<std::shared_ptr<const scene::EnvironmentImage>> load_map(const std::string& name);
  struct Placement {
    glm::dmat4 world_from_object{1};
    std::optional<glm::dvec3> target;  // of look_at
  };
  Placement place(Draws& draws, const Entry& fields, const state::PoseState& poses,
                  const glm::dmat4& world_from_object) const;
  Result<void> check_variants() const;
  Result<void> check_given() const;
  Result<void> check_lights() const;
  void warn_of_no_effect();
  void warn_once(const std::string& text);
  void warn_of_driven_nodes(const state::PoseState& poses);

  const Plan& plan_;
  std::vector<Object> cameras_, nodes_, materials_, lights_, distractors_;
  size_t camera_count_;
  const scene::Scene* scene_ = nullptr;
  std::optional<state::NodeNames> names_;  // of the scene
  float exposure_ = 1;
  uint64_t frame_ = 0;
  std::map<uint64_t, std::map<std::string, DrawnValue>> given_;  // by frame
  DrawnValues of_frame_, of_image_;
  double noise_ = 0;
  std::set<std::string> warned_;
  std::map<std::string, std::shared_ptr<const scene::EnvironmentImage>> maps_;  // the last ones
  // Of the frame: nodes to settle, and those that are not drawn.
  std::vector<Object> settling_;
  std::set<uint32_t> hidden_;
  std::optional<SettleShapes> shapes_;                                    // of the scene
  enum class Step : uint8_t { settle, lights, done } step_ = Step::done;  // of add_transforms()
};

}  // namespace fire3dv::dataset
