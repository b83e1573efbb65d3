// Command interpreter of the test publishers: ROS 2 messages by lines on standard input, over either DDS
// library.
//
//   open KIND [TOPIC]              a writer: tf, tf_static, clock, joint_states or robot_description
//   open_wrong TOPIC               a writer of std_msgs/String under this name
//   readers KIND                   answers "ok N": matched readers
//   transform PARENT CHILD STAMP_NS [X Y Z [QX QY QZ QW]]   into the next message; "" is an empty name, @N
//                                  one of N letters
//   send tf|tf_static              publishes the transforms since the last message
//   text FILE                      publishes the file as robot_description
//   clock STAMP_NS
//   joints STAMP_NS [NAME POSITION ...]
//   moving_joints STAMP_NS [NAME POSITION VELOCITY EFFORT ...]
//   chain COUNT STAMP_NS STEP      transforms f0 -> f1 -> ... into the next message, STEP metres along x
//   load COUNT RATE SECONDS PER_MESSAGE   publishes COUNT moving frames below "map" at this rate
//   damaged KIND COUNT SEED        COUNT messages with bytes changed, cut off or lengthened; "ok unsupported"
//                                  from Cyclone DDS, which sends none
//   marker NS ID ACTION FRAME X Y Z [LIFETIME_NS]   a cube in a message of topic "markers"; Cyclone DDS alone
//   quit
//
// Each line is answered by one that begins with "ok" or "error".
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace fire3dv::ros2_test {

struct TestTransform {
  std::string parent, child;
  int64_t stamp_ns = 0;
  std::array<double, 3> translation{};
  std::array<double, 4> rotation{0, 0, 0, 1};
};

struct TestJoint {
  std::string name;
  double position = 0, velocity = 0, effort = 0;
};

class MessageWriter {
 public:
  virtual ~MessageWriter() = default;
  virtual bool open(const std::string& kind, const std::string& topic) = 0;  // kind: as in "open", or "wrong"
  virtual size_t readers(const std::string& kind) = 0;
  virtual bool send_transforms(const std::string& kind, const std::vector<TestTransform>& transforms) = 0;
  virtual bool send_text(const std::string& text) = 0;
  virtual bool send_clock(int64_t stamp_ns) = 0;
  // is_moving: with velocities and efforts.
  virtual bool send_joints(int64_t stamp_ns, const std::vector<TestJoint>& joints, bool is_moving) = 0;
  virtual bool send_marker(const TestTransform& /*frame, namespace, place*/, int /*id*/, int /*action*/,
                           int64_t /*lifetime_ns*/) {
    return false;
  }
  virtual bool send_damaged(const std::string& /*kind*/, size_t /*count*/, unsigned /*seed*/) {
    return false;
  }
};

// Runs until "quit" or the end of the input. Returns the exit code.
int run_commands(MessageWriter& writer);

// Seconds and nanoseconds of a stamp.
inline std::pair<int32_t, uint32_t> stamp_parts(int64_t stamp_ns) {
  int64_t seconds = stamp_ns / 1'000'000'000, rest = stamp_ns % 1'000'000'000;
  if (rest < 0) {
    --seconds;
    rest += 1'000'000'000;
  }
  return {static_cast<int32_t>(seconds), static_cast<uint32_t>(rest)};
}

// Quality of service of ROS 2's own publishers.
struct TopicQuality {
  const char *topic, *type;
  bool transient_local;
  int32_t depth;
};
const TopicQuality& quality(const std::string& kind);

}  // namespace fire3dv::ros2_test
