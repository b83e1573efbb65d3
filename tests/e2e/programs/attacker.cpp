// Hostile publisher over real links, for attackers_test.py: sends messages that the client library refuses to
// send. An honest publisher with optional credentials checks that the renderer still serves others.
//
//   attacker credentials                        creates certificates and a key, prints their files, and
//                                               keeps them until its input ends
//   attacker good URI NAME [OPTION FILE]...     publishes until its input ends; prints "welcome" on Welcome
//   attacker messages URI                       sends invalid names, numbers and orders, each on its own link
//   attacker nodes URI COUNT                    describes COUNT nodes and prints the answer
//
// Options: key (udp://), ca (tls://).
#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <string>
#include <thread>

#include "base/random.h"
#include "protocol/transport/open.h"
#include "protocol/wire/decode.h"
#include "protocol/wire/encode.h"
#include "tests/support/certificates.h"

namespace {

using namespace std::chrono_literals;
namespace wire = fire3dv::wire;
namespace transport = fire3dv::transport;

constexpr auto kHangLimit = 200s;

class Speaker {
 public:
  explicit Speaker(const std::string& uri, const transport::PublisherOptions& options = {}) {
    auto opened = transport::open_publisher(uri, options);
    if (!opened) fail(opened.error().message);
    link_ = std::move(*opened);
    description_.epoch = fire3dv::random_id();
    description_.adapter_name = "attacker";
    description_.node_names = {"green"};
  }
  [[noreturn]] static void fail(const std::string& what) {
    std::fprintf(stderr, "attacker: %s\n", what.c_str());
    std::exit(1);
  }

  wire::StreamDescription& description() { return description_; }
  void describe() { say_first(wire::encode(description_)); }
  void say_first(const wire::Bytes& message) {
    if (auto set = link_->set_description(message); !set) fail(set.error().message);
  }
  void say(const wire::Message& message) {
    std::visit(
        [&](const auto& value) {
          if constexpr (requires { wire::encode(value); }) link_->send_control(wire::encode(value));
        },
        message);
  }
  void pose(uint64_t sequence, float value = 0, uint32_t nodes = 1, uint64_t epoch = 0) {
    std::vector<wire::Affine3x4> poses(nodes);
    poses[0].m[3] = value;
    wire::PoseFrameView frame;
    frame.header.epoch = epoch != 0 ? epoch : description_.epoch;
    frame.header.sequence = sequence;
    frame.node_count = nodes;
    frame.poses = poses;
    link_->publish(encoder_.encode(frame));
  }
  // Waits for the next Welcome and returns its status.
  int welcome(std::string* text = nullptr) {
    wire::Bytes answer;
    const auto until = std::chrono::steady_clock::now() + kHangLimit;
    while (std::chrono::steady_clock::now() < until) {
      while (link_->poll(answer)) {
        const auto message = decoder_.decode(answer);
        const auto* found = message ? std::get_if<wire::Welcome>(&*message) : nullptr;
        if (found == nullptr) continue;
        if (text != nullptr) *text = found->message;
        return static_cast<int>(found->status);
      }
      std::this_thread::sleep_for(1ms);
    }
    fail("no welcome came; " + link_->problem());
  }
  // Returns once the renderer has handled all earlier messages: the link keeps the order, and a pong answers
  // the last ping. A ping before the connection is lost, so pings repeat.
  void wait_until_heard() {
    const uint64_t first = pings_ + 1;
    wire::Bytes answer;
    const auto until = std::chrono::steady_clock::now() + kHangLimit;
    for (int turn = 0; std::chrono::steady_clock::now() < until; ++turn) {
      if (turn % 100 == 0) link_->send_control(wire::encode(wire::Ping{++pings_, 1}));
      while (link_->poll(answer)) {
        const auto message = decoder_.decode(answer);
        const auto* pong = message ? std::get_if<wire::Pong>(&*message) : nullptr;
        if (pong != nullptr && pong->id >= first) return;
      }
      std::this_thread::sleep_for(1ms);
    }
    fail("no pong came; " + link_->problem());
  }

 private:
  std::unique_ptr<transport::PublisherLink> link_;
  wire::StreamDescription description_;
  wire::PoseFrameEncoder encoder_;
  wire::Decoder decoder_;
  uint64_t pings_ = 0;
};

bool input_ended() {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  char byte;
  return ::poll(&input, 1, 5) > 0 && ::read(STDIN_FILENO, &byte, 1) <= 0;
}

int credentials() {
  const fire3dv::test::Credentials made;
  const auto authority = made.authority("authority");
  const auto server = made.identity("server", "IP:127.0.0.1", authority);
  std::printf("ca=%s cert=%s certkey=%s key=%s other=%s\n", authority.certificate_file.c_str(),
              server.certificate_file.c_str(), server.key_file.c_str(), made.key("key", '5').c_str(),
              made.key("other", '6').c_str());
  std::fflush(stdout);
  while (!input_ended()) {
  }
  return 0;
}

int good(int argc, char** argv) {
  transport::PublisherOptions options;
  for (int i = 4; i + 1 < argc; i += 2)
    (std::string(argv[i]) == "key" ? options.key_file : options.tls.ca_file) = argv[i + 1];
  Speaker speaker(argv[2], options);
  speaker.description().adapter_name = argv[3];
  speaker.describe();
  if (const int status = speaker.welcome(); status != 0) Speaker::fail("refused: " + std::to_string(status));
  std::printf("welcome\n");
  std::fflush(stdout);
  for (uint64_t sequence = 1; !input_ended(); ++sequence) speaker.pose(sequence);
  return 0;
}

// Sends each attack on its own link. Links may drop poses, so poses that must be handled repeat, each
// followed by a ping.
int messages(const std::string& uri) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  int refused = 0;
  const auto names = [&](const std::string& name) {
    Speaker speaker(uri);
    speaker.description().node_names = {"red", name};
    speaker.describe();
    refused += speaker.welcome() == static_cast<int>(wire::WelcomeStatus::bad_description);
  };
  for (const char* name : {"\x1b[2J\x1b[31m", "a\nfire3dv: all is well", "\x7f", "\xc2\x9b", "\xe2\x80\xae",
                           "", "\xff\xfe", "\xed\xa0\x80"})
    names(name);
  names(std::string("nul\0", 4));
  names(std::string(5000, 'n'));

  const auto numbers = [&](const std::function<void(wire::StreamDescription&)>& spoil) {
    Speaker speaker(uri);
    spoil(speaker.description());
    speaker.describe();
    refused += speaker.welcome() == static_cast<int>(wire::WelcomeStatus::bad_description);
  };
  numbers([&](auto& d) { d.world_from_stream.m[0] = std::numeric_limits<double>::quiet_NaN(); });
  numbers([&](auto& d) { d.world_from_stream.m[3] = 1e300; });
  numbers([&](auto& d) { d.nominal_rate_hz = -1; });
  numbers([&](auto& d) { d.epoch = 0; });
  numbers([&](auto& d) { d.adapter_name = "a\rb"; });

  {
    Speaker wild(uri);
    wild.describe();
    (void)wild.welcome();
    for (uint64_t sequence = 1; sequence <= 40; ++sequence) {
      for (const float value : {nan, infinity, -infinity, 1e30f}) wild.pose(sequence, value);
      wild.pose(sequence, 0, 2);       // more nodes than described
      wild.pose(sequence, 0, 1, 777);  // unknown epoch
      wild.wait_until_heard();
    }
    wild.pose(UINT64_MAX);  // every later sequence is older
    wild.wait_until_heard();
    wild.pose(1);
    wild.wait_until_heard();
  }

  Speaker disorderly(uri);
  disorderly.say_first(wire::encode(wire::Goodbye{5}));
  for (uint64_t sequence = 1; sequence <= 40; ++sequence) {
    disorderly.pose(sequence);
    disorderly.say(wire::Pong{1, 2, 3});
    disorderly.say(wire::Welcome{});
    disorderly.say(wire::Ack{1, 2});
    disorderly.wait_until_heard();
  }
  disorderly.describe();
  refused += disorderly.welcome() != 0;  // earlier violations do not block a valid description
  disorderly.say(wire::Goodbye{disorderly.description().epoch});
  for (uint64_t sequence = 1; sequence <= 10; ++sequence) {
    disorderly.pose(sequence);
    disorderly.wait_until_heard();
  }
  std::printf("refused=%d\n", refused);
  return 0;
}

int nodes(const std::string& uri, size_t count) {
  Speaker speaker(uri);
  auto& names = speaker.description().node_names;
  names.clear();
  names.reserve(count);
  for (size_t i = 0; i < count; ++i) names.push_back(std::to_string(i));
  speaker.describe();
  std::string text;
  const int status = speaker.welcome(&text);
  std::printf("status=%d message=%s\n", status, text.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string mode = argc > 1 ? argv[1] : "";
  if (mode == "credentials") return credentials();
  if (mode == "good" && argc >= 4) return good(argc, argv);
  if (mode == "messages" && argc == 3) return messages(argv[2]);
  if (mode == "nodes" && argc == 4) return nodes(argv[2], std::strtoull(argv[3], nullptr, 10));
  std::fprintf(stderr, "usage: attacker credentials|good|messages|nodes ...\n");
  return 2;
}
