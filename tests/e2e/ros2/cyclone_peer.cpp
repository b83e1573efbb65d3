// A ROS 2 graph without ROS: publishes transforms and a robot description, and reads topics by Cyclone DDS.
//
//   ros2_image_peer publish
//     Standard input, a line each: "tf STAMP_NS PARENT CHILD X Y Z QX QY QZ QW" adds a transform, "send" and
//     "send_static" publish those added; "description FILE" publishes a file on /robot_description. Prints
//     "readers TF STATIC DESCRIPTION" after each "readers".
//   ros2_image_peer read TOPIC image|compressed|info|tf_static reliable|best_effort [FOLDER]
//     Prints one JSON object for each message; data of images goes to FOLDER/N.data. Ends with its standard
//     input.
#include <unistd.h>

#include <poll.h>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <iterator>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "adapters/ros2/dds/participant.h"
#include "adapters/ros2/dds/topics.h"

namespace fire3dv::ros2 {
namespace {

[[noreturn]] void fail(const std::string& what) {
  std::fprintf(stderr, "ros2_image_peer: error: %s\n", what.c_str());
  std::exit(1);
}

template <typename Value>
Value take(Result<Value> result) {
  if (!result) fail(result.error().message);
  return std::move(*result);
}

void say(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}

// Names with spaces are quoted: std::quoted reads both kinds.
struct Transforms {
  std::deque<std::string> names;
  std::vector<geometry_msgs_msg_dds__TransformStamped_> list;

  void add(std::istream& line) {
    int64_t stamp_ns = 0;
    std::string parent, child;
    geometry_msgs_msg_dds__TransformStamped_ added{};
    auto& [t, r] = added.transform;
    line >> stamp_ns >> std::quoted(parent) >> std::quoted(child) >> t.x >> t.y >> t.z >> r.x >> r.y >> r.z >>
        r.w;
    if (!line) fail("a transform is not complete");
    added.header.stamp = {static_cast<int32_t>(stamp_ns / 1'000'000'000),
                          static_cast<uint32_t>(stamp_ns % 1'000'000'000)};
    added.header.frame_id = names.emplace_back(parent).data();
    added.child_frame_id = names.emplace_back(child).data();
    list.push_back(added);
  }
  void send(Writer<TfMessage>& writer) {
    TfMessage message{};
    message.transforms._maximum = message.transforms._length = static_cast<uint32_t>(list.size());
    message.transforms._buffer = list.data();
    if (const Result<void> written = writer.write(message); !written) fail(written.error().message);
    list.clear();
    names.clear();
  }
};

void publish(const Participant& participant) {
  auto tf = take(Writer<TfMessage>::open(participant, "/tf", Profile::tf));
  auto tf_static = take(Writer<TfMessage>::open(participant, "/tf_static", Profile::tf_static));
  auto description =
      take(Writer<StringMessage>::open(participant, "/robot_description", Profile::robot_description));
  Transforms transforms;
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::string command;
    words >> command;
    if (command == "tf") {
      transforms.add(words);
    } else if (command == "send") {
      transforms.send(tf);
    } else if (command == "send_static") {
      transforms.send(tf_static);
    } else if (command == "description") {
      std::string path;
      words >> path;
      std::ifstream file(path, std::ios::binary);
      std::string text{std::istreambuf_iterator<char>(file), {}};
      if (text.empty()) fail("cannot read " + path);
      StringMessage message{text.data()};
      if (const Result<void> written = description.write(message); !written) fail(written.error().message);
    } else if (command == "readers") {
      say("readers " + std::to_string(tf.reader_count()) + " " + std::to_string(tf_static.reader_count()) +
          " " + std::to_string(description.reader_count()));
    } else {
      fail("unknown command " + command);
    }
  }
}

std::string json(const std_msgs_msg_dds__Header_& header) {
  return "\"stamp_ns\": " + std::to_string(header.stamp.sec * int64_t{1'000'000'000} + header.stamp.nanosec) +
         ", \"frame_id\": \"" + header.frame_id + "\"";
}

template <typename Numbers>
std::string json(const Numbers& numbers, size_t count) {
  std::ostringstream text;
  text.precision(17);
  for (size_t i = 0; i < count; ++i) text << (i ? ", " : "[") << numbers[i];
  return text.str() + "]";
}

class Printer {
 public:
  explicit Printer(std::string folder) : folder_(std::move(folder)) {}

  void print(const ImageMessage& m) {
    store(m.data);
    say("{" + json(m.header) + ", \"height\": " + std::to_string(m.height) +
        ", \"width\": " + std::to_string(m.width) + ", \"encoding\": \"" + m.encoding +
        "\", \"step\": " + std::to_string(m.step) + ", \"is_bigendian\": " + std::to_string(m.is_bigendian) +
        ", \"data\": \"" + path_ + "\"}");
  }
  void print(const CompressedImageMessage& m) {
    store(m.data);
    say("{" + json(m.header) + ", \"format\": \"" + m.format + "\", \"data\": \"" + path_ + "\"}");
  }
  void print(const CameraInfoMessage& m) {
    say("{" + json(m.header) + ", \"height\": " + std::to_string(m.height) +
        ", \"width\": " + std::to_string(m.width) + ", \"distortion_model\": \"" + m.distortion_model +
        "\", \"d\": " + json(m.d._buffer, m.d._length) + ", \"k\": " + json(m.k, 9) +
        ", \"r\": " + json(m.r, 9) + ", \"p\": " + json(m.p, 12) + "}");
  }
  void print(const TfMessage& m) {
    for (uint32_t i = 0; i < m.transforms._length; ++i) {
      const auto& t = m.transforms._buffer[i];
      const double values[] = {t.transform.translation.x, t.transform.translation.y,
                               t.transform.translation.z, t.transform.rotation.x,
                               t.transform.rotation.y,    t.transform.rotation.z,
                               t.transform.rotation.w};
      say("{" + json(t.header) + ", \"child_frame_id\": \"" + t.child_frame_id +
          "\", \"transform\": " + json(values, 7) + "}");
    }
  }

 private:
  void store(const dds_sequence_uint8& data) {
    path_ = folder_ + "/" + std::to_string(++count_) + ".data";
    std::ofstream(path_, std::ios::binary).write(reinterpret_cast<const char*>(data._buffer), data._length);
  }

  std::string folder_, path_;
  uint64_t count_ = 0;
};

template <typename Message>
void read(const Participant& participant, const std::string& topic, bool transient_local, bool reliable,
          const std::string& folder) {
  UniqueQos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_SECS(1));
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 100);
  if (transient_local) dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  const Entity reader = take(create_reader(participant, topic, kMessageType<Message>, qos.get()));
  Printer printer(folder);
  bool has_matched = false;
  while (true) {
    dds_subscription_matched_status_t matched{};
    dds_get_subscription_matched_status(reader.get(), &matched);
    if (!has_matched && matched.current_count > 0) say("\"matched\"");
    has_matched = has_matched || matched.current_count > 0;
    void* samples[8] = {};
    dds_sample_info_t infos[8];
    const dds_return_t count = dds_take(reader.get(), samples, infos, 8, 8);
    for (dds_return_t i = 0; i < count; ++i)
      if (infos[i].valid_data) printer.print(*static_cast<const Message*>(samples[i]));
    if (count > 0) dds_return_loan(reader.get(), samples, count);
    pollfd input{STDIN_FILENO, POLLIN, 0};
    char byte;
    if (::poll(&input, 1, count > 0 ? 0 : 2) > 0 && ::read(STDIN_FILENO, &byte, 1) <= 0) return;
  }
}

int run(int argc, char** argv) {
  const auto settings = take(domain_settings([](const char* name) { return std::getenv(name); }));
  const auto participant = take(Participant::open(settings));
  const std::string mode = argc > 1 ? argv[1] : "";
  if (mode == "publish") {
    publish(*participant);
  } else if (mode == "read" && argc >= 5) {
    const std::string topic = argv[2], type = argv[3], folder = argc > 5 ? argv[5] : "";
    const bool reliable = argv[4] == std::string("reliable");
    if (type == "image")
      read<ImageMessage>(*participant, topic, false, reliable, folder);
    else if (type == "compressed")
      read<CompressedImageMessage>(*participant, topic, false, reliable, folder);
    else if (type == "info")
      read<CameraInfoMessage>(*participant, topic, false, reliable, folder);
    else if (type == "tf_static")
      read<TfMessage>(*participant, topic, true, reliable, folder);
    else
      fail("unknown type " + type);
  } else {
    fail("usage: publish | read TOPIC image|compressed|info|tf_static reliable|best_effort [FOLDER]");
  }
  return 0;
}

}  // namespace
}  // namespace fire3dv::ros2

int main(int argc, char** argv) {
  return fire3dv::ros2::run(argc, argv);
}
