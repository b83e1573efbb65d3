// Parity datagrams: bytes of the wire, the number that a loss demands, and their receiver under lies and
// floods.
#include "protocol/transport/udp/udp_parity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "base/clock.h"
#include "tests/unit/protocol/transport/link_fixture.h"

namespace fire3dv::transport::test {
namespace {

using Payload = std::vector<std::byte>;

// Parity of a whole frame as SPEC-transport.md describes it.
std::vector<Payload> parity_of_frame(uint64_t frame, const std::vector<std::string>& parts, size_t rows) {
  std::vector<Payload> payloads;
  const auto count = static_cast<uint32_t>(parts.size());
  const uint32_t groups = udp::parity_groups(count);
  for (size_t row = 0; row < rows; ++row) {
    for (uint32_t group = 0; group < groups; ++group) {
      size_t longest = 0;
      for (size_t part = group; part < count; part += groups) longest = std::max(longest, parts[part].size());
      Payload payload(udp::kParityHeaderBytes + 2 + longest);
      udp::write_parity_header(payload.data(),
                               {frame, count, static_cast<uint16_t>(group), static_cast<uint8_t>(row)});
      const auto symbol = std::span(payload).subspan(udp::kParityHeaderBytes);
      for (size_t part = group; part < count; part += groups) {
        const size_t bytes = parts[part].size();
        const std::byte length[2] = {static_cast<std::byte>(bytes), static_cast<std::byte>(bytes >> 8)};
        const uint8_t factor = udp::parity_factor(row, part / groups);
        udp::gf_multiply_add(symbol, length, factor);
        udp::gf_multiply_add(symbol.subspan(2), bytes_of(parts[part]), factor);
      }
      payloads.push_back(std::move(payload));
    }
  }
  return payloads;
}

std::vector<std::string> make_parts(size_t count) {
  std::vector<std::string> parts;
  for (size_t i = 0; i < count; ++i) parts.push_back(std::string(20 + i % 7, 'a') + std::to_string(i));
  return parts;
}

void start(udp::ParityReceiver& receiver) {  // parts are stored once parity has come
  for (const Payload& payload : parity_of_frame(1, {"first"}, 1)) EXPECT_TRUE(receiver.add_parity(payload));
  EXPECT_EQ(receiver.take_restored().size(), 1u);
}

// Golden bytes, computed from the specification by another program.
TEST(UdpParity, BytesAreThoseOfTheSpecification) {
  const std::vector<Payload> parity =
      parity_of_frame(0x0102030405060708, {"arm", std::string("hand\x80"), "x"}, 2);
  ASSERT_EQ(parity.size(), 2u);
  const uint8_t expected[2][23] = {
      {8, 7, 6, 5, 4, 3, 2, 1, 3, 0, 0, 0, 0, 0, 0, 0, 0x95, 0x00, 0xab, 0xf0, 0xef, 0xbb, 0x55},
      {8, 7, 6, 5, 4, 3, 2, 1, 3, 0, 0, 0, 0, 0, 1, 0, 0x96, 0x00, 0x02, 0xa5, 0x3e, 0xa5, 0x01}};
  for (size_t row = 0; row < 2; ++row)
    EXPECT_TRUE(std::ranges::equal(parity[row], std::as_bytes(std::span(expected[row])))) << row;
}

TEST(UdpParity, NumberFollowsTheLoss) {
  EXPECT_EQ(udp::parity_symbols_for(15, 0), 0u);
  EXPECT_EQ(udp::parity_symbols_for(15, 0.001), 1u);
  EXPECT_EQ(udp::parity_symbols_for(15, 0.05), 4u);
  EXPECT_EQ(udp::parity_symbols_for(15, 0.3), 13u);
  EXPECT_EQ(udp::parity_symbols_for(50, 0.05), 8u);
  EXPECT_EQ(udp::parity_symbols_for(1, 0.05), 1u) << "a repetition";
  EXPECT_EQ(udp::parity_symbols_for(1, 0.3), 1u) << "never more than data";
  udp::ParityRate rate({});
  EXPECT_FALSE(rate.is_on()) << "the listener may be an older one";
  udp::Receipt receipt;
  int64_t now_ns = kSecondNs;
  const auto run = [&](uint64_t lost_of_100, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      receipt.newest += 100;
      receipt.received += 100 - lost_of_100;
      rate.report(receipt, now_ns += 100 * kMillisecondNs);
    }
  };
  run(0, 20);
  EXPECT_EQ(rate.symbols(15), 0u) << "nothing is lost, nothing is sent";
  run(5, 1);
  EXPECT_GE(rate.symbols(15), 1u) << "from the first loss on";
  run(5, 50);
  EXPECT_GE(rate.symbols(15), 4u);
  EXPECT_LE(rate.symbols(15), 6u);
  run(30, 10);
  EXPECT_GE(rate.symbols(15), 13u) << "a rise counts immediately";
  run(0, 60);
  EXPECT_EQ(rate.symbols(15), 0u);
}

TEST(UdpParity, ReportsThatLieAreHarmless) {
  udp::ParityRate rate({});
  for (const udp::Receipt receipt :
       {udp::Receipt{10, 10}, {UINT64_MAX, 0}, {5, 5}, {UINT64_MAX, UINT64_MAX}, {0, UINT64_MAX}}) {
    rate.report(receipt, kSecondNs);
    EXPECT_LE(rate.symbols(64), udp::kMaxParitySymbols);
  }
}

TEST(UdpParity, PercentageIsKept) {
  udp::ParityRate rate(10, false);
  size_t data = 0, parity = 0;
  for (int frame = 0; frame < 1000; ++frame) {
    data += 15;
    parity += rate.symbols(15);
  }
  EXPECT_NEAR(static_cast<double>(parity), static_cast<double>(data) / 10, 1.0);
  EXPECT_FALSE(udp::ParityRate(0, false).is_on());
}

TEST(UdpParity, LostPartsAreRestoredInAnyOrder) {
  std::mt19937 generator(3);
  for (const size_t count : {1u, 2u, 15u, 64u, 65u, 150u}) {
    udp::ParityReceiver receiver;
    start(receiver);
    const std::vector<std::string> parts = make_parts(count);
    const std::vector<Payload> parity = parity_of_frame(7, parts, 4);
    std::vector<size_t> order(count + parity.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::ranges::shuffle(order, generator);
    std::vector<std::string> got(count);
    for (const size_t i : order) {
      if (i < std::min<size_t>(count, 3)) continue;  // lost, of one group at least one
      if (i < count) {
        if (!receiver.has_part(7, static_cast<uint16_t>(i))) got[i] = parts[i];
        receiver.add_part(7, static_cast<uint16_t>(i), i + 1 == count, bytes_of(parts[i]));
      } else {
        EXPECT_TRUE(receiver.add_parity(parity[i - count]));
      }
      for (const auto& restored : receiver.take_restored()) {
        EXPECT_EQ(restored.frame, 7u);
        EXPECT_EQ(restored.is_last, restored.part + 1u == count);
        EXPECT_TRUE(got[restored.part].empty()) << "once";
        got[restored.part] = text_of(restored.message);
      }
    }
    EXPECT_EQ(got, parts) << count;
    receiver.close_up_to(7);
    EXPECT_EQ(receiver.memory_bytes(), 0u);
  }
}

TEST(UdpParity, NothingIsStoredWithoutParity) {
  udp::ParityReceiver receiver;
  receiver.add_part(1, 0, true, bytes_of("part"));
  EXPECT_EQ(receiver.memory_bytes(), 0u);
  start(receiver);
  receiver.close_up_to(1);
  receiver.add_part(1'000'000, 0, true, bytes_of("part"));
  EXPECT_EQ(receiver.memory_bytes(), 0u) << "long without parity";
}

TEST(UdpParity, LiesAreDropped) {
  const std::vector<std::string> parts = make_parts(15);
  const std::vector<Payload> parity = parity_of_frame(7, parts, 2);
  udp::ParityReceiver receiver;
  start(receiver);
  EXPECT_FALSE(receiver.add_parity({}));
  EXPECT_FALSE(receiver.add_parity(std::span(parity[0]).first(udp::kParityHeaderBytes)));
  EXPECT_TRUE(receiver.add_parity(parity[0]));
  EXPECT_FALSE(receiver.add_parity(std::span(parity[1]).first(parity[1].size() - 1))) << "another length";
  Payload other = parity[1];
  other[8] = std::byte{16};
  EXPECT_FALSE(receiver.add_parity(other)) << "another number of parts";
  for (const auto& [at, value] : {std::pair{0, 0}, {8, 0}, {12, 1}, {14, 64}}) {
    Payload impossible = parity_of_frame(9, {"x"}, 1)[0];
    impossible[static_cast<size_t>(at)] = static_cast<std::byte>(value);
    EXPECT_FALSE(receiver.add_parity(impossible)) << at;
  }
  // Parts longer than the symbols, and lengths that no part has.
  for (uint64_t frame = 10; frame < 20; ++frame) {
    std::mt19937 generator(static_cast<uint32_t>(frame));
    Payload wild = parity_of_frame(frame, parts, 1)[0];
    for (size_t i = udp::kParityHeaderBytes; i < wild.size(); ++i)
      wild[i] = static_cast<std::byte>(generator());
    for (uint16_t part = 1; part < 15; ++part)
      receiver.add_part(frame, part, part == 14, bytes_of(std::string(frame == 10 ? 900 : 20, 'x')));
    receiver.add_parity(wild);
    for (const auto& restored : receiver.take_restored())
      EXPECT_LE(restored.message.size(), wild.size() - udp::kParityHeaderBytes);
  }
}

TEST(UdpParity, FloodsAreBounded) {
  std::mt19937_64 generator(1);
  udp::ParityReceiver receiver;
  start(receiver);
  for (int i = 0; i < 30'000; ++i) {
    const uint64_t frame = 2 + generator() % 300;
    if (i % 2 == 0) {
      Payload payload(udp::kParityHeaderBytes + 3 + generator() % 40);
      const auto count = static_cast<uint32_t>(generator() % 8 == 0 ? 65'536 : 1 + generator() % 200);
      udp::write_parity_header(payload.data(),
                               {frame, count, static_cast<uint16_t>(generator() % udp::parity_groups(count)),
                                static_cast<uint8_t>(generator() % 64)});
      receiver.add_parity(payload);
    } else {
      receiver.add_part(frame, static_cast<uint16_t>(generator()), generator() % 50 == 0,
                        bytes_of(std::string(generator() % 1100, 'x')));
    }
    ASSERT_LE(receiver.memory_bytes(), udp::ParityReceiver::kMaxBytes);
    receiver.take_restored();
  }
  receiver.clear();
  EXPECT_EQ(receiver.memory_bytes(), 0u);
}

}  // namespace
}  // namespace fire3dv::transport::test
