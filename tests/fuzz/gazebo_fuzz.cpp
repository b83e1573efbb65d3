// Fuzz target of what Gazebo's peers send: discovery datagrams, scenes, poses and deletions. The first byte
// selects the parser; a message after another one meets the state that it left.
#include <cmath>
#include <span>
#include <string>
#include <string_view>

#include "adapters/gazebo/wire/directory.h"
#include "adapters/gazebo/world/world.h"
#include "base/error.h"
#include "tests/fuzz/target.h"

namespace fire3dv::fuzz {
namespace {

template <typename T>
Input input_of(uint8_t kind, const T& message) {
  const std::string bytes = message.SerializeAsString();
  Input input{kind};
  input.insert(input.end(), bytes.begin(), bytes.end());
  return input;
}

}  // namespace

std::vector<Input> seeds() {
  namespace pb = gazebo::pb;
  std::vector<Input> inputs;
  gazebo::Advertisement topic;
  topic.topic = "@/p@/t";
  topic.address = "tcp://127.0.0.1:1234";
  topic.process_uuid = "p";
  for (const auto type :
       {gazebo::DiscoveryType::advertise, gazebo::DiscoveryType::subscribe, gazebo::DiscoveryType::bye}) {
    gazebo::DiscoveryMessage message;
    message.process_uuid = "p";
    message.type = type;
    message.topic = topic.topic;
    if (type == gazebo::DiscoveryType::advertise) message.advertisement = topic;
    Input input{0};
    for (const std::byte b : gazebo::encode_discovery(message)) input.push_back(std::to_integer<uint8_t>(b));
    inputs.push_back(std::move(input));
  }
  pb::Scene scene;
  pb::Model& model = *scene.add_model();
  model.set_name("m");
  model.set_id(1);
  pb::Link& link = *model.add_link();
  link.set_id(2);
  link.add_visual()->mutable_geometry()->mutable_box()->mutable_size()->set_x(1);
  link.add_sensor()->mutable_camera()->set_horizontal_fov(1);
  link.mutable_sensor(0)->set_type("camera");
  model.add_model()->add_link()->set_id(5);
  scene.add_light()->set_id(9);
  inputs.push_back(input_of(1, scene));
  pb::PoseV poses;
  poses.mutable_header()->mutable_stamp()->set_sec(3);
  poses.add_pose()->set_id(2);
  poses.mutable_pose(0)->mutable_orientation()->set_w(1);
  poses.mutable_pose(0)->mutable_position()->set_x(2);
  inputs.push_back(input_of(2, poses));
  inputs.push_back(input_of(3, poses));
  pb::UInt32V ids;
  ids.add_data(1);
  inputs.push_back(input_of(4, ids));
  return inputs;
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv;
  static gazebo::Directory directory("p");
  static gazebo::World world;
  static int64_t now_ns = 0;
  if (size == 0) return 0;
  now_ns += 1'000'000;
  const int length = static_cast<int>(size - 1);
  switch (data[0] % 5) {
    case 0: {
      const auto message = gazebo::decode_discovery(std::as_bytes(std::span(data + 1, size - 1)));
      if (!message) return 0;
      // What was understood is written and read the same.
      const auto again = gazebo::decode_discovery(gazebo::encode_discovery(*message));
      FIRE3DV_ASSERT(again && again->type == message->type && again->process_uuid == message->process_uuid);
      directory.take(*message, true, now_ns);
      (void)directory.take_gone(now_ns);
      FIRE3DV_ASSERT(directory.peers() <= gazebo::Directory::kMaxPeers);
      return 0;
    }
    case 1: {
      gazebo::pb::Scene scene;
      if (!scene.ParseFromArray(data + 1, length)) return 0;
      world.update(scene);
      for (size_t i = 0; i < world.items().size(); ++i) world.item(i).is_streamed = true;
      break;
    }
    case 2:
    case 3: {
      gazebo::pb::PoseV poses;
      if (!poses.ParseFromArray(data + 1, length)) return 0;
      world.apply(poses, data[0] % 5 == 2 ? gazebo::PoseTopic::dynamic : gazebo::PoseTopic::full, now_ns);
      break;
    }
    default: {
      gazebo::pb::UInt32V ids;
      if (!ids.ParseFromArray(data + 1, length)) return 0;
      world.remove(ids);
    }
  }
  (void)world.take_warnings();
  std::vector<float> poses;
  world.write_poses(poses);
  FIRE3DV_ASSERT(poses.size() == 12 * world.node_names().size());
  for (const float value : poses) FIRE3DV_ASSERT(std::isfinite(value) && std::abs(value) <= 1e12f);
  return 0;
}
