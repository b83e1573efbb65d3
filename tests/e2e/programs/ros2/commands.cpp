#include "tests/e2e/programs/ros2/commands.h"

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <sstream>
#include <thread>

namespace fire3dv::ros2_test {
namespace {

std::string name_of(const std::string& word) {
  if (word == "\"\"") return "";
  if (word.size() > 1 && word[0] == '@') return std::string(std::strtoul(word.c_str() + 1, nullptr, 10), 'x');
  return word;
}

double number_of(const std::string& word) {
  return std::strtod(word.c_str(), nullptr);  // also nan and inf
}

bool load(MessageWriter& writer, size_t count, double rate_hz, double seconds, size_t per_message) {
  const auto begin = std::chrono::steady_clock::now();
  const auto period =
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(1 / rate_hz));
  const auto rounds = static_cast<int64_t>(rate_hz * seconds);
  std::vector<TestTransform> message;
  for (int64_t round = 1; round <= rounds; ++round) {
    std::this_thread::sleep_until(begin + round * period);
    for (size_t i = 0; i < count; ++i) {
      TestTransform& t = message.emplace_back();
      t.parent = "map";
      t.child = "f" + std::to_string(i);
      t.stamp_ns = 1'000'000'000 + round * period.count();
      t.translation = {static_cast<double>(i), static_cast<double>(round), 0};
      if (message.size() < per_message && i + 1 < count) continue;
      if (!writer.send_transforms("tf", message)) return false;
      message.clear();
    }
  }
  return true;
}

class Interpreter {
 public:
  explicit Interpreter(MessageWriter& writer) : writer_(writer) {}

  std::string answer(const std::string& command, std::istringstream& words) {
    std::string a, b;
    if (command == "open") {
      words >> a >> b;
      return said(writer_.open(a, b.empty() ? quality(a).topic : b));
    }
    if (command == "open_wrong") {
      words >> a;
      return said(writer_.open("wrong", a));
    }
    if (command == "readers") {
      words >> a;
      return "ok " + std::to_string(writer_.readers(a));
    }
    if (command == "transform") {
      TestTransform t;
      words >> a >> b >> t.stamp_ns;
      t.parent = name_of(a);
      t.child = name_of(b);
      for (double& number : t.translation)
        if (words >> a) number = number_of(a);
      for (double& number : t.rotation)
        if (words >> a) number = number_of(a);
      transforms_.push_back(t);
      return "ok";
    }
    if (command == "send") {
      words >> a;
      return said(writer_.send_transforms(a, std::exchange(transforms_, {})));
    }
    if (command == "text") {
      words >> a;
      std::ifstream file(a, std::ios::binary);
      return said(writer_.send_text({std::istreambuf_iterator<char>(file), {}}));
    }
    if (command == "clock") {
      int64_t stamp_ns = 0;
      words >> stamp_ns;
      return said(writer_.send_clock(stamp_ns));
    }
    if (command == "marker") {
      TestTransform t;
      int id = 0, action = 0;
      words >> t.child >> id >> action >> t.parent;
      for (double& number : t.translation)
        if (words >> a) number = number_of(a);
      int64_t lifetime_ns = 0;
      words >> lifetime_ns;
      return said(writer_.send_marker(t, id, action, lifetime_ns));
    }
    if (command == "damaged") {
      size_t count = 0;
      unsigned seed = 0;
      words >> a >> count >> seed;
      return writer_.send_damaged(a, count, seed) ? "ok" : "ok unsupported";
    }
    if (command == "joints" || command == "moving_joints") return joints(words, command != "joints");
    if (command == "chain") return chain(words);
    if (command == "load") {
      size_t count = 0, per_message = 0;
      double rate_hz = 0, seconds = 0;
      words >> count >> rate_hz >> seconds >> per_message;
      return said(load(writer_, count, rate_hz, seconds, per_message));
    }
    return "error unknown command";
  }

 private:
  static std::string said(bool good) { return good ? "ok" : "error"; }

  std::string joints(std::istringstream& words, bool is_moving) {
    int64_t stamp_ns = 0;
    std::vector<TestJoint> joints;
    std::string name, position, velocity = "0", effort = "0";
    words >> stamp_ns;
    while (words >> name >> position && (!is_moving || words >> velocity >> effort))
      joints.push_back({name, number_of(position), number_of(velocity), number_of(effort)});
    return said(writer_.send_joints(stamp_ns, joints, is_moving));
  }

  std::string chain(std::istringstream& words) {
    size_t count = 0;
    int64_t stamp_ns = 0;
    double step = 0;
    words >> count >> stamp_ns >> step;
    for (size_t i = 0; i < count; ++i) {
      TestTransform& t = transforms_.emplace_back();
      t.parent = "f" + std::to_string(i);
      t.child = "f" + std::to_string(i + 1);
      t.stamp_ns = stamp_ns;
      t.translation[0] = step;
    }
    return "ok";
  }

  MessageWriter& writer_;
  std::vector<TestTransform> transforms_;
};

}  // namespace

const TopicQuality& quality(const std::string& kind) {
  static const std::map<std::string, TopicQuality> all = {
      {"tf", {"/tf", "tf2_msgs::msg::dds_::TFMessage_", false, 100}},
      {"tf_static", {"/tf_static", "tf2_msgs::msg::dds_::TFMessage_", true, 1}},
      {"clock", {"/clock", "rosgraph_msgs::msg::dds_::Clock_", false, 10}},
      {"joint_states", {"/joint_states", "sensor_msgs::msg::dds_::JointState_", false, 10}},
      {"robot_description", {"/robot_description", "std_msgs::msg::dds_::String_", true, 1}},
      {"markers", {"/markers", "visualization_msgs::msg::dds_::MarkerArray_", false, 10}},
      {"wrong", {"", "std_msgs::msg::dds_::String_", false, 10}},
  };
  const auto found = all.find(kind);
  return found == all.end() ? all.at("wrong") : found->second;
}

int run_commands(MessageWriter& writer) {
  Interpreter interpreter(writer);
  std::cout << "ready" << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::string command;
    words >> command;
    if (command == "quit") break;
    std::cout << interpreter.answer(command, words) << std::endl;
  }
  return 0;
}

}  // namespace fire3dv::ros2_test
