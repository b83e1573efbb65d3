// One peer of a renderer: an honest adapter that counts its images, or an attacker (greedy_attacks.h).
//
//   greedy_peer honest tcp://HOST:PORT [edits] [describes]
//       Publishes poses and waits for the image of each frame until "quit" comes. For each line "report" it
//       prints what happened since the last one. edits: adds and removes a node every 10 frames; describes:
//       describes its stream again every 50 frames.
//   greedy_peer attack NAME tcp=URI udp=URI epoch=HEX asset=FILE nodes=A,B
//       Attacks until a line comes or input ends, then prints the bytes it sent.
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "fire3dv/client.hpp"
#include "tests/e2e/programs/greedy_attacks.h"
#include "tests/e2e/programs/raw_peer.h"

namespace fire3dv::test {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr uint32_t kWidth = 320, kHeight = 240;
constexpr size_t kPoses = 8;           // the motion repeats after so many frames
constexpr auto kFrameTimeout = 500ms;  // then the image is lost, and the next frame is published
constexpr int kEditEvery = 10, kDescribeEvery = 50;

uint64_t hash_of(const fire3dv_image& image) {
  uint64_t hash = 0xcbf29ce484222325;
  for (size_t i = 0; i < image.plane_count; ++i) {
    const auto& plane = image.planes[i];
    const auto* bytes = static_cast<const unsigned char*>(plane.data);
    for (size_t b = 0; b < size_t{plane.row_stride} * plane.height; ++b)
      hash = (hash ^ bytes[b]) * 0x100000001b3;
  }
  return hash;
}

class Honest {
 public:
  Honest(const std::string& uri, bool edits, bool describes)
      : stream_(uri, "honest"), edits_(edits), describes_(describes) {
    stream_.describe({"body", "root/left/twin"});
    fire3dv_image_request request{};
    request.node = "camera";
    request.width = kWidth;
    request.height = kHeight;
    request.when = FIRE3DV_IMAGE_EVERY_NTH;
    request_ = stream_.request_image(request);
  }

  int run() {
    while (!quit_) step();
    return 0;
  }

 private:
  void step() {
    ++frame_;
    const size_t number = frame_ % kPoses;
    const auto x = 0.2f * static_cast<float>(number);
    const Pose pose{1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0};
    if (edits_ && frame_ % (2 * kEditEvery) == kEditEvery) stream_.add_node("own");
    if (edits_ && frame_ % (2 * kEditEvery) == 0) stream_.remove_node("own");
    if (describes_ && frame_ % kDescribeEvery == 0) stream_.describe({"body", "root/left/twin"});
    stream_.publish(std::chrono::milliseconds(frame_), {pose, pose});
    const uint64_t sequence = stream_.poll().sequence;
    const auto until = Clock::now() + kFrameTimeout;
    while (Clock::now() < until) {
      const Image image = stream_.wait_image(request_, 20ms);
      if (image && image->sequence == sequence) {
        take(*image, number);
        return read_commands();
      }
      read_commands();
      if (quit_) return;
    }
    ++lost_;
  }

  // The first image of each pose is the reference: the test has no attack running by then.
  void take(const fire3dv_image& image, size_t number) {
    const uint64_t hash = hash_of(image);
    if (!expected_[number]) expected_[number] = hash;
    changed_ += *expected_[number] != hash;
    ++images_;
    longest_gap_ = std::max(longest_gap_, Clock::now() - last_);
    last_ = Clock::now();
  }

  void report() {
    const auto gap = std::max(longest_gap_, Clock::now() - last_);
    std::printf("images=%llu changed=%llu lost=%llu longest_gap_ms=%lld unmatched=%u epoch=%016llx\n",
                static_cast<unsigned long long>(images_), static_cast<unsigned long long>(changed_),
                static_cast<unsigned long long>(lost_),
                static_cast<long long>(std::chrono::duration_cast<std::chrono::milliseconds>(gap).count()),
                stream_.poll().unmatched_names, static_cast<unsigned long long>(stream_.poll().epoch));
    std::fflush(stdout);
    images_ = changed_ = lost_ = 0;
    longest_gap_ = {};
  }

  void read_commands() {
    for (pollfd input{STDIN_FILENO, POLLIN, 0}; !quit_ && ::poll(&input, 1, 0) > 0;) {
      std::string line;
      for (char byte = 0; ::read(STDIN_FILENO, &byte, 1) == 1 && byte != '\n';) line += byte;
      if (line == "report") report();
      if (line != "report") quit_ = true;
    }
  }

  Stream stream_;
  const bool edits_, describes_;
  bool quit_ = false;
  uint64_t request_ = 0, frame_ = 0;
  std::optional<uint64_t> expected_[kPoses];
  uint64_t images_ = 0, changed_ = 0, lost_ = 0;
  Clock::time_point last_ = Clock::now();
  Clock::duration longest_gap_{};
};

int honest(const std::vector<std::string>& arguments) {
  const auto has = [&](const char* word) {
    return std::find(arguments.begin() + 2, arguments.end(), word) != arguments.end();
  };
  return Honest(arguments[1], has("edits"), has("describes")).run();
}

int attack(const std::vector<std::string>& arguments) {
  const auto found = greedy_attacks().find(arguments[1]);
  if (found == greedy_attacks().end()) {
    std::fprintf(stderr, "greedy_peer: no attack is called %s\n", arguments[1].c_str());
    return 2;
  }
  Target target;
  for (const std::string& argument : arguments) {
    const std::string value = argument.substr(argument.find('=') + 1);
    if (argument.starts_with("tcp=")) target.tcp_uri = value;
    if (argument.starts_with("udp=")) target.udp_uri = value;
    if (argument.starts_with("epoch=")) target.epoch = std::strtoull(value.c_str(), nullptr, 16);
    if (argument.starts_with("asset=")) target.asset = value;
    std::istringstream nodes(argument.starts_with("nodes=") ? value : "");
    for (std::string node; std::getline(nodes, node, ',');) target.nodes.push_back(node);
  }
  // The scheduler gives the renderer what time it asks for: what is tested is the renderer, not the machine.
  (void)!::nice(5);
  int closed = 0;
  while (!stop_requested()) {
    try {
      found->second(target);
    } catch (const PeerClosed&) {
      ++closed;
      std::this_thread::sleep_for(100ms);
    }
  }
  std::printf("bytes=%llu closed=%d\n", static_cast<unsigned long long>(RawPeer::bytes_sent()), closed);
  return 0;
}

}  // namespace
}  // namespace fire3dv::test

int main(int argc, char** argv) try {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() >= 2 && arguments[0] == "honest") return fire3dv::test::honest(arguments);
  if (arguments.size() >= 2 && arguments[0] == "attack") return fire3dv::test::attack(arguments);
  for (const auto& [name, run] : fire3dv::test::greedy_attacks()) std::printf("%s\n", name.c_str());
  return 2;
} catch (const fire3dv::ClientError& error) {
  std::printf("error=%s\n", error.what());
  return 1;
}
