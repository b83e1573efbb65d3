// Fuzz target of TCP framing: a byte stream cut at positions that the input chooses. No message is longer
// than the received bytes, and memory stays within them.
#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "protocol/transport/tcp/tcp_frame.h"
#include "tests/fuzz/target.h"

namespace fire3dv::fuzz {

using namespace transport::tcp;

std::vector<Input> seeds() {
  std::vector<Input> inputs;
  for (const uint32_t bytes : {0u, 1u, 300u, 70'000u}) {
    Input input = {static_cast<uint8_t>(bytes % 251)};
    const PrefaceBytes preface = write_preface({});
    for (const std::byte byte : preface) input.push_back(static_cast<uint8_t>(byte));
    for (const FrameKind kind : {FrameKind::control, FrameKind::pose}) {
      for (const std::byte byte : write_frame_header(kind, bytes))
        input.push_back(static_cast<uint8_t>(byte));
      input.insert(input.end(), bytes, uint8_t{0x5a});
    }
    inputs.push_back(std::move(input));
  }
  return inputs;
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv::transport;
  if (size < 1 + tcp::kPrefaceBytes) return 0;
  const size_t step = 1 + data[0];
  const auto stream = std::as_bytes(std::span(data + 1, size - 1));
  tcp::Preface preface;
  if (!tcp::read_preface(stream.first<tcp::kPrefaceBytes>(), preface)) return 0;
  constexpr size_t kLimit = 1 << 20;
  size_t charged = 0;
  {
    tcp::FrameParser parser([&](size_t bytes) {
      if (bytes > kLimit) return false;
      charged = bytes;
      return true;
    });
    size_t fed = 0, got = 0;
    auto rest = stream.subspan(tcp::kPrefaceBytes);
    while (!rest.empty()) {
      const auto piece = rest.first(std::min(step, rest.size()));
      rest = rest.subspan(piece.size());
      fed += piece.size();
      const auto fault = parser.feed(piece, [&](tcp::FrameKind, std::vector<std::byte>&& message) {
        got += tcp::kFrameHeaderBytes + message.size();
        FIRE3DV_ASSERT(got <= fed);
      });
      FIRE3DV_ASSERT(charged <= kLimit);
      if (fault != tcp::FrameParser::Fault::none) break;
    }
  }
  FIRE3DV_ASSERT(charged == 0);
  return 0;
}
