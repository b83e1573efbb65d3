// Gazebo server without a simulator, on Debian 12's ignition-transport: the other side of fire3dv-gazebo's
// tests.
//
//   gazebo_peer gz|ignition WORLD PARTITION
//
// Reads commands, one per line, and answers each with "ok":
//
//   model NAME ID X BOX_SIZE       Adds and announces a model: link ID+1, box ID+2, camera ID+3, depth camera
//                                  ID+4.
//   nested NAME ID PARENT_ID X     Adds a model below another one.
//   forget ID                      Removes a model without an announcement.
//   delete ID                      Removes a model and announces that.
//   dynamic SEC NSEC [ID X Y Z]... Publishes poses.
//   pose SEC NSEC [ID X Y Z]...    Publishes poses on the topic of all poses.
//   raw TOPIC TYPE HEX             Publishes these bytes.
//   images TOPIC                   Subscribes. Prints each image, with the pixel in its middle:
//                                  image WIDTHxHEIGHT SEC NSEC FORMAT BYTES R G B
//                                  depth WIDTHxHEIGHT SEC NSEC FORMAT BYTES METRES CORNER_METRES
//   infos TOPIC                    Subscribes. Prints each CameraInfo as JSON after "info ".
//   wait                           Waits until somebody subscribes to dynamic poses.
//   quit
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <ignition/msgs.hh>
#include <ignition/transport/Node.hh>
#include <iostream>
#include <map>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>

#include "gz_types.pb.h"

namespace {

namespace msgs = ignition::msgs;
namespace transport = ignition::transport;

std::mutex guard;  // of the scene and the output
msgs::Scene scene;

void say(const std::string& line) {
  const std::lock_guard<std::mutex> lock(guard);
  std::cout << line << std::endl;
}

void set_pose(msgs::Pose& pose, double x, double y, double z) {
  pose.mutable_position()->set_x(x);
  pose.mutable_position()->set_y(y);
  pose.mutable_position()->set_z(z);
  pose.mutable_orientation()->set_w(1);
}

void fill_model(msgs::Model& model, const std::string& name, uint32_t id, double x, double size) {
  model.set_name(name);
  model.set_id(id);
  set_pose(*model.mutable_pose(), x, 0, 0);
  msgs::Link& link = *model.add_link();
  link.set_name("link");
  link.set_id(id + 1);
  set_pose(*link.mutable_pose(), 0, 0, 0.5);
  msgs::Visual& visual = *link.add_visual();
  visual.set_name("visual");
  visual.set_id(id + 2);
  set_pose(*visual.mutable_pose(), 0, 0, 0);
  visual.mutable_geometry()->set_type(msgs::Geometry::BOX);
  msgs::Vector3d& extent = *visual.mutable_geometry()->mutable_box()->mutable_size();
  extent.set_x(size);
  extent.set_y(size);
  extent.set_z(size);
  msgs::Color& diffuse = *visual.mutable_material()->mutable_diffuse();
  diffuse.set_r(1);
  diffuse.set_a(1);
  msgs::Color& emissive = *visual.mutable_material()->mutable_emissive();
  emissive.set_r(1);
  emissive.set_a(1);
  msgs::Sensor& sensor = *link.add_sensor();
  sensor.set_name("camera");
  sensor.set_id(id + 3);
  sensor.set_type("camera");
  sensor.set_update_rate(10);
  sensor.set_topic("/" + name + "/image");
  set_pose(*sensor.mutable_pose(), -3 * size, 0, 0);
  sensor.mutable_camera()->set_horizontal_fov(1);
  sensor.mutable_camera()->mutable_image_size()->set_x(32);
  sensor.mutable_camera()->mutable_image_size()->set_y(24);
  sensor.mutable_camera()->set_near_clip(0.1);
  sensor.mutable_camera()->set_far_clip(100);
  msgs::Sensor& depth = *link.add_sensor();
  depth = sensor;
  depth.set_name("depth");
  depth.set_id(id + 4);
  depth.set_type("depth_camera");
  depth.mutable_camera()->mutable_distortion()->set_k1(0.125);
  depth.mutable_camera()->mutable_distortion()->set_p2(-0.0625);
  depth.clear_topic();
}

msgs::Model* find(google::protobuf::RepeatedPtrField<msgs::Model>& models, uint32_t id) {
  for (msgs::Model& model : models) {
    if (model.id() == id) return &model;
    if (msgs::Model* nested = find(*model.mutable_model(), id)) return nested;
  }
  return nullptr;
}

void erase(uint32_t id) {
  auto& models = *scene.mutable_model();
  for (int i = 0; i < models.size(); ++i) {
    if (models.Get(i).id() != id) continue;
    models.DeleteSubrange(i, 1);
    return;
  }
}

std::string bytes_of_hex(const std::string& hex) {
  std::string bytes;
  for (size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  return bytes;
}

void on_image(const msgs::Image& image) {
  std::ostringstream line;
  const std::string& data = image.data();
  const bool is_depth = image.pixel_format_type() == msgs::R_FLOAT32;
  line << (is_depth ? "depth " : "image ") << image.width() << "x" << image.height() << " "
       << image.header().stamp().sec() << " " << image.header().stamp().nsec() << " "
       << image.pixel_format_type() << " " << data.size();
  if (is_depth) {
    float metres[2] = {};
    const size_t middle = (image.height() / 2) * image.step() + 4 * (image.width() / 2);
    if (middle + 4 <= data.size()) {
      std::memcpy(metres, data.data() + middle, 4);
      std::memcpy(metres + 1, data.data(), 4);
    }
    line << " " << metres[0] << " " << metres[1];
    return say(line.str());
  }
  const size_t middle = (image.height() / 2) * image.step() + 3 * (image.width() / 2);
  for (size_t i = 0; i < 3 && middle + i < data.size(); ++i)
    line << " " << int(static_cast<unsigned char>(data[middle + i]));
  say(line.str());
}

template <typename List>
std::string json_list(const List& numbers) {
  std::ostringstream text;
  text.precision(17);
  for (const double number : numbers) text << (text.tellp() > 0 ? ", " : "[") << number;
  return numbers.empty() ? "[]" : text.str() + "]";
}

void on_info(const msgs::CameraInfo& info) {
  std::ostringstream line;
  line << "info {\"width\": " << info.width() << ", \"height\": " << info.height()
       << ", \"sec\": " << info.header().stamp().sec() << ", \"nsec\": " << info.header().stamp().nsec();
  for (const msgs::Header::Map& entry : info.header().data())
    line << ", \"" << entry.key() << "\": \"" << (entry.value_size() == 1 ? entry.value(0) : "") << "\"";
  line << ", \"model\": \""
       << msgs::CameraInfo::Distortion::DistortionModelType_Name(info.distortion().model())
       << "\", \"d\": " << json_list(info.distortion().k()) << ", \"k\": " << json_list(info.intrinsics().k())
       << ", \"p\": " << json_list(info.projection().p())
       << ", \"r\": " << json_list(info.rectification_matrix()) << "}";
  say(line.str());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const bool is_gz = std::string(argv[1]) == "gz";
  const std::string prefix = std::string(argv[1]) + ".msgs.", world = std::string("/world/") + argv[2] + "/";
  transport::NodeOptions options;
  options.SetPartition(argv[3]);
  transport::Node node(options);
  scene.set_name(argv[2]);

  std::map<std::string, transport::Node::Publisher> publishers;
  const auto publish = [&](const std::string& topic, const std::string& type, const std::string& bytes) {
    auto found = publishers.find(topic);
    if (found == publishers.end()) found = publishers.emplace(topic, node.Advertise(topic, type)).first;
    found->second.PublishRaw(bytes, type);
  };
  for (const auto& [topic, type] : {std::pair<const char*, const char*>("dynamic_pose/info", "Pose_V"),
                                    {"pose/info", "Pose_V"},
                                    {"scene/info", "Scene"},
                                    {"scene/deletion", "UInt32_V"}})
    publishers.emplace(world + topic, node.Advertise(world + topic, prefix + type));
  if (is_gz) {
    node.Advertise<gz::msgs::Empty, gz::msgs::Scene>(
        world + "scene/info",
        std::function<bool(const gz::msgs::Empty&, gz::msgs::Scene&)>([](const auto&, auto& answer) {
          const std::lock_guard<std::mutex> lock(guard);
          return answer.ParseFromString(scene.SerializeAsString());
        }));
  } else {
    node.Advertise<msgs::Empty, msgs::Scene>(
        world + "scene/info",
        std::function<bool(const msgs::Empty&, msgs::Scene&)>([](const auto&, auto& answer) {
          const std::lock_guard<std::mutex> lock(guard);
          answer = scene;
          return true;
        }));
  }

  std::string line;
  while (std::getline(std::cin, line)) {
    std::istringstream words(line);
    std::string command, name;
    words >> command;
    uint32_t id = 0, parent = 0;
    if (command == "quit") break;
    if (command == "model" || command == "nested") {
      double x = 0, size = 1;
      words >> name >> id;
      if (command == "nested") words >> parent;
      words >> x >> size;
      msgs::Scene added;
      {
        const std::lock_guard<std::mutex> lock(guard);
        msgs::Model& model = parent ? *find(*scene.mutable_model(), parent)->add_model() : *scene.add_model();
        fill_model(model, name, id, x, size);
        *added.add_model() = model;
      }
      publish(world + "scene/info", prefix + "Scene", added.SerializeAsString());
    } else if (command == "delete" || command == "forget") {
      words >> id;
      {
        const std::lock_guard<std::mutex> lock(guard);
        erase(id);
      }
      msgs::UInt32_V ids;
      ids.add_data(id);
      if (command == "delete")
        publish(world + "scene/deletion", prefix + "UInt32_V", ids.SerializeAsString());
    } else if (command == "dynamic" || command == "pose") {
      int64_t sec = 0;
      int32_t nsec = 0;
      words >> sec >> nsec;
      msgs::Pose_V poses;
      poses.mutable_header()->mutable_stamp()->set_sec(sec);
      poses.mutable_header()->mutable_stamp()->set_nsec(nsec);
      double x = 0, y = 0, z = 0;
      std::string sx, sy, sz;
      while (words >> id >> sx >> sy >> sz) {
        x = std::stod(sx), y = std::stod(sy), z = std::stod(sz);  // takes nan, too
        msgs::Pose& pose = *poses.add_pose();
        pose.set_id(id);
        set_pose(pose, x, y, z);
      }
      publish(world + (command == "pose" ? "pose/info" : "dynamic_pose/info"), prefix + "Pose_V",
              poses.SerializeAsString());
    } else if (command == "raw") {
      std::string topic, type, hex;
      words >> topic >> type >> hex;
      publish(topic, type, bytes_of_hex(hex));
    } else if (command == "images") {
      words >> name;
      node.SubscribeRaw(name, [](const char* data, size_t size, const transport::MessageInfo&) {
        msgs::Image image;
        if (image.ParseFromArray(data, static_cast<int>(size))) on_image(image);
      });
    } else if (command == "infos") {
      words >> name;
      node.SubscribeRaw(name, [](const char* data, size_t size, const transport::MessageInfo& from) {
        msgs::CameraInfo info;
        if (from.Type().ends_with(".msgs.CameraInfo") && info.ParseFromArray(data, static_cast<int>(size)))
          on_info(info);
      });
    } else if (command == "wait") {
      while (!publishers.at(world + "dynamic_pose/info").HasConnections())
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      std::this_thread::sleep_for(std::chrono::milliseconds(200));  // for the other topics
    }
    say("ok");
  }
  std::_Exit(0);  // the library's threads may wait for each other at exit
}
