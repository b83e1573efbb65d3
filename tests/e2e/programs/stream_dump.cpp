// Stream dump: prints each message of a link as a line of JSON, in the format of the golden messages.
// stream_dump URI LIMIT_S: first prints its URI; ends when a stream says goodbye or is gone.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "protocol/transport/open.h"
#include "protocol/wire/decode.h"
#include "tests/conformance/json_message.h"

int main(int argc, char** argv) {
  using namespace fire3dv;
  if (argc != 3) return 2;
  transport::ListenerOptions options;
  options.delivery = transport::Delivery::all;
  auto link = transport::open_listener(argv[1], options);
  if (!link) {
    std::fprintf(stderr, "%s\n", link.error().message.c_str());
    return 1;
  }
  std::printf("%s\n", (*link)->uri().c_str());
  std::fflush(stdout);
  wire::Decoder decoder;
  // A poll reads controls after poses: a goodbye may overtake poses, which one more poll delivers.
  bool over = false, is_last = false;
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(std::atoi(argv[2]));
  while (!is_last && std::chrono::steady_clock::now() < until) {
    is_last = over;
    (*link)->wait(std::chrono::milliseconds(10));
    (*link)->poll([&](const transport::LinkEvent& event) {
      using Kind = transport::LinkEvent::Kind;
      over = over || event.kind == Kind::disconnected;
      if (event.kind != Kind::pose && event.kind != Kind::control) return;
      const auto message = decoder.decode(event.message);
      if (!message) {
        std::fprintf(stderr, "%s\n", message.error().message.c_str());
        return;
      }
      over = over || std::holds_alternative<wire::Goodbye>(*message);
      std::printf("%s\n", conformance::to_json(*message).dump().c_str());
      std::fflush(stdout);
    });
  }
  return over ? 0 : 1;
}
