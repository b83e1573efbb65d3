#include "protocol/transport/udp/udp_parity.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "base/clock.h"
#include "protocol/transport/core/byte_order.h"

namespace fire3dv::transport::udp {
namespace {

constexpr int64_t kLongWindowNs = 4 * kSecondNs, kShortWindowNs = kSecondNs / 2;
constexpr int64_t kReportStepNs = 20 * kMillisecondNs;  // closer reports replace each other
constexpr uint64_t kLeastDatagrams = 30;                // of the short window
constexpr double kMaxLoss = 0.6;
constexpr double kLossStep = 0.005;
constexpr size_t kSymbolOverheadBytes = 64;  // allocation of one stored symbol

}  // namespace

void write_parity_header(std::byte* to, const ParityHeader& header) {
  put_le<uint64_t>(to, header.frame);
  put_le<uint32_t>(to + 8, header.parts);
  put_le<uint16_t>(to + 12, header.group);
  to[14] = static_cast<std::byte>(header.row);
  to[15] = std::byte{0};
}

bool read_parity_header(std::span<const std::byte> payload, ParityHeader& header) {
  if (payload.size() < kParityHeaderBytes) return false;
  header.frame = get_le<uint64_t>(payload.data());
  header.parts = get_le<uint32_t>(payload.data() + 8);
  header.group = get_le<uint16_t>(payload.data() + 12);
  header.row = static_cast<uint8_t>(payload[14]);
  return header.frame != 0 && header.parts != 0 && header.parts <= kMaxFrameParts &&
         header.group < parity_groups(header.parts) && header.row < kMaxParitySymbols;
}

// --- publisher

double LossMeter::loss_since(int64_t begin_ns) const {
  const auto first = std::ranges::find_if(reports_, [&](const Report& r) { return r.at_ns >= begin_ns; });
  const Report& begin = first != reports_.end() ? *first : reports_.back();
  const Report& end = reports_.back();
  const uint64_t sent = end.receipt.newest - begin.receipt.newest;
  const uint64_t lost = sent - std::min(sent, end.receipt.received - begin.receipt.received);
  if (lost == 0) return 0;
  const auto count = static_cast<double>(lost);
  return std::min((count + std::sqrt(count)) / static_cast<double>(sent), kMaxLoss);
}

void LossMeter::report(const Receipt& receipt, int64_t now_ns) {
  if (!reports_.empty()) {
    const Receipt& last = reports_.back().receipt;
    if (receipt.newest < last.newest || receipt.received < last.received) return;  // overtaken, or a lie
  }
  if (reports_.size() > 1 && now_ns - reports_[reports_.size() - 2].at_ns < kReportStepNs)
    reports_.pop_back();
  reports_.push_back({receipt, now_ns});
  while (now_ns - reports_.front().at_ns > kLongWindowNs && reports_.size() > 1) reports_.pop_front();
  loss_ = loss_since(now_ns - kLongWindowNs);
  const auto recent =
      std::ranges::find_if(reports_, [&](const Report& r) { return r.at_ns >= now_ns - kShortWindowNs; });
  if (receipt.newest - recent->receipt.newest >= kLeastDatagrams)
    loss_ = std::max(loss_, loss_since(now_ns - kShortWindowNs));
}

size_t parity_symbols_for(size_t data_symbols, double loss) {
  if (loss <= 0) return 0;
  const double accepted = std::max(0.003, loss / 10);
  // Where a crowded link is the cause, parity adds to the crowd: at most as many bytes again.
  const size_t most = std::min(data_symbols, kMaxParitySymbols);
  for (size_t parity = 0; parity < most; ++parity) {
    const auto symbols = static_cast<double>(data_symbols + parity);
    double probability = std::pow(1 - loss, symbols);  // that exactly `lost` symbols are lost
    double restored = probability;
    for (size_t lost = 1; lost <= parity; ++lost) {
      const auto l = static_cast<double>(lost);
      probability *= (symbols - l + 1) / l * loss / (1 - loss);
      restored += probability;
    }
    if (1 - restored <= accepted) return parity;
  }
  return most;
}

void ParityRate::report(const Receipt& receipt, int64_t now_ns) {
  meter_.report(receipt, now_ns);
  const double loss = std::ceil(meter_.loss() / kLossStep) * kLossStep;
  if (loss == planned_loss_) return;
  planned_loss_ = loss;
  for_loss_.fill(UINT8_MAX);
}

bool ParityRate::is_on() const {
  if (needs_reports_ && !meter_.has_reports()) return false;  // the listener may not know parity
  return percent_ ? *percent_ != 0 : meter_.loss() > 0;
}

size_t ParityRate::symbols(size_t data_symbols) {
  if (!is_on()) return 0;
  if (percent_) {
    fraction_left_ += static_cast<double>(data_symbols) * *percent_ / 100;
    const size_t count = std::min(static_cast<size_t>(fraction_left_), kMaxParitySymbols);
    fraction_left_ = std::min(fraction_left_ - static_cast<double>(count), 1.0);
    return count;
  }
  uint8_t& count = for_loss_[data_symbols];
  if (count == UINT8_MAX) count = static_cast<uint8_t>(parity_symbols_for(data_symbols, planned_loss_));
  return count;
}

// --- listener

void ParityReceiver::drop(OpenFrame& frame) {
  bytes_ -= frame.bytes;
  frame.clear();
}

void ParityReceiver::clear() {
  close_up_to(UINT64_MAX);
  closed_ = 0;
}

void ParityReceiver::close_up_to(uint64_t frame) {
  if (frame <= closed_) return;
  closed_ = frame;
  const auto is_closed = [&](const OpenFrame& open) { return open.sequence != 0 && open.sequence <= frame; };
  while (OpenFrame* const open = frames_.oldest_where(is_closed)) drop(*open);
}

ParityReceiver::OpenFrame* ParityReceiver::open(uint64_t frame) {
  if (OpenFrame* const known = frames_.find(frame)) return known;
  if (frames_.size() == kMaxFrames) {
    OpenFrame* const oldest = frames_.oldest_where([](const OpenFrame&) { return true; });
    if (oldest->sequence > frame) return nullptr;
    drop(*oldest);
  }
  return frames_.open(frame);
}

// Accounts for memory of a frame. Returns false if the frame was dropped for it.
bool ParityReceiver::store(OpenFrame& frame, size_t bytes) {
  while (bytes_ + bytes > kMaxBytes) {
    OpenFrame* const oldest = frames_.oldest_where([](const OpenFrame& open) { return open.sequence != 0; });
    const bool is_own = oldest == &frame;
    drop(*oldest);
    if (is_own) return false;
  }
  frame.bytes += bytes;
  bytes_ += bytes;
  return true;
}

// Returns false if the frame is gone: contradictory, or dropped for lack of memory.
bool ParityReceiver::place(OpenFrame& frame, uint16_t part, std::vector<std::byte> symbol) {
  const size_t cost = symbol.size() + kSymbolOverheadBytes;
  if (frame.parts == 0) {
    if (!store(frame, cost)) return false;
    frame.parts_before.emplace_back(part, std::move(symbol));
    return true;
  }
  if (part >= frame.parts) {
    drop(frame);
    return false;
  }
  const auto groups = static_cast<uint32_t>(frame.groups.size());
  Group& group = frame.groups[part % groups];
  const size_t column = part / groups;
  const uint64_t bit = uint64_t{1} << column;
  if ((group.data_seen & bit) != 0) return true;
  group.data_seen |= bit;
  if (group.is_done) return true;
  if (!store(frame, cost)) return false;
  if (group.data.size() <= column) group.data.resize(column + 1);
  group.data[column] = std::move(symbol);
  restore(frame, part % groups);
  return true;
}

bool ParityReceiver::set_parts(OpenFrame& frame, uint32_t parts) {
  if (frame.parts != 0) return frame.parts == parts;
  constexpr size_t kGroupBytes =
      sizeof(Group) + (kMaxDataSymbols + kMaxParitySymbols) * sizeof(std::vector<std::byte>);
  if (!store(frame, parity_groups(parts) * kGroupBytes)) return false;
  frame.parts = parts;
  frame.groups.resize(parity_groups(parts));
  auto before = std::exchange(frame.parts_before, {});
  for (const auto& [part, symbol] : before) {
    const size_t cost = symbol.size() + kSymbolOverheadBytes;
    frame.bytes -= cost;
    bytes_ -= cost;
  }
  for (auto& [part, symbol] : before)
    if (!place(frame, part, std::move(symbol))) return false;
  return true;
}

void ParityReceiver::add_part(uint64_t frame, uint16_t part, bool is_last,
                              std::span<const std::byte> message) {
  if (last_parity_frame_ == 0 || frame <= closed_) return;
  if (frame > last_parity_frame_ && frame - last_parity_frame_ > kActiveFrames) return;
  if (message.size() > UINT16_MAX) return;
  OpenFrame* const open_frame = open(frame);
  if (open_frame == nullptr || (is_last && !set_parts(*open_frame, uint32_t{part} + 1))) return;
  std::vector<std::byte> symbol(2 + message.size());
  put_le<uint16_t>(symbol.data(), static_cast<uint16_t>(message.size()));
  std::ranges::copy(message, symbol.begin() + 2);
  place(*open_frame, part, std::move(symbol));
}

bool ParityReceiver::add_parity(std::span<const std::byte> payload) {
  ParityHeader header;
  if (!read_parity_header(payload, header)) return false;
  const std::span<const std::byte> symbol = payload.subspan(kParityHeaderBytes);
  if (symbol.size() <= 2) return false;
  if (header.frame <= closed_) return true;
  last_parity_frame_ = std::max(last_parity_frame_, header.frame);
  OpenFrame* const frame = open(header.frame);
  if (frame == nullptr) return true;
  if (!set_parts(*frame, header.parts)) return false;
  Group& group = frame->groups[header.group];
  const uint64_t bit = uint64_t{1} << header.row;
  if (group.is_done || (group.rows_seen & bit) != 0) return true;
  if (group.symbol_bytes != 0 && group.symbol_bytes != symbol.size()) return false;
  if (!store(*frame, symbol.size() + kSymbolOverheadBytes)) return true;
  group.symbol_bytes = symbol.size();
  group.rows_seen |= bit;
  if (group.parity.size() <= header.row) group.parity.resize(size_t{header.row} + 1);
  group.parity[header.row].assign(symbol.begin(), symbol.end());
  restore(*frame, header.group);
  return true;
}

// Restores the missing parts of a group once it has as many symbols as parts.
void ParityReceiver::restore(OpenFrame& frame, uint32_t group_index) {
  Group& group = frame.groups[group_index];
  const size_t parts = parts_of_group(frame.parts, group_index);
  const auto received = static_cast<size_t>(std::popcount(group.data_seen));
  if (received < parts && received + static_cast<size_t>(std::popcount(group.rows_seen)) < parts) return;
  group.is_done = true;
  ReceivedSymbols symbols;
  symbols.bytes = group.symbol_bytes;
  symbols.data.assign(parts, {});
  bool is_sound = true;
  for (size_t column = 0; column < group.data.size(); ++column) {
    symbols.data[column] = group.data[column];
    is_sound = is_sound && (received == parts || group.data[column].size() <= group.symbol_bytes);
  }
  std::vector<std::vector<std::byte>> restored;
  if (received < parts && is_sound) {
    symbols.parity.assign(group.parity.begin(), group.parity.end());
    restored = restore_symbols(symbols);
  }
  for (size_t column = 0, next = 0; column < parts && next < restored.size(); ++column) {
    if (!symbols.data[column].empty()) continue;
    std::vector<std::byte>& symbol = restored[next++];
    const size_t bytes = get_le<uint16_t>(symbol.data());
    const uint64_t bit = uint64_t{1} << column;
    if (bytes == 0 || bytes + 2 > symbol.size()) continue;  // the publisher contradicts itself
    const size_t part = column * frame.groups.size() + group_index;
    group.data_seen |= bit;
    restored_.push_back({frame.sequence,
                         static_cast<uint16_t>(part),
                         part + 1 == frame.parts,
                         {symbol.begin() + 2, symbol.begin() + 2 + static_cast<std::ptrdiff_t>(bytes)}});
  }
  const auto release = [&](std::vector<std::vector<std::byte>>& stored) {
    for (const auto& symbol : stored) {
      if (symbol.empty()) continue;
      frame.bytes -= symbol.size() + kSymbolOverheadBytes;
      bytes_ -= symbol.size() + kSymbolOverheadBytes;
    }
    stored = {};
  };
  release(group.data);
  release(group.parity);
}

bool ParityReceiver::has_part(uint64_t frame, uint16_t part) const {
  if (last_parity_frame_ == 0) return false;
  const OpenFrame* const open = frames_.find(frame);
  if (open == nullptr || part >= open->parts) return false;
  const size_t groups = open->groups.size();
  return (open->groups[part % groups].data_seen >> (part / groups) & 1) != 0;
}

}  // namespace fire3dv::transport::udp
