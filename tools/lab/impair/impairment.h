// Impairment model of a network: parameters, counters, outages, and the fate of datagrams and streams,
// without sockets or clock. Seeded: equal datagrams in equal order are treated equally, and connections break
// at equal bytes. The relay drives it in real time, tests and benchmarks in simulated time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace fire3dv::impair {

struct Impairment {
  double loss = 0;       // datagrams: probability of loss
  double duplicate = 0;  // datagrams: probability of duplication
  double reorder = 0;    // datagrams: probability of overtaking earlier ones, by omitting the delay
  int64_t delay_ns = 0;
  int64_t jitter_ns = 0;           // uniform variation of the delay, in both directions
  uint64_t bits_per_second = 0;    // 0: unlimited. Datagrams are dropped if they would queue for more than
                                   // 200 ms
  uint64_t stall_after_bytes = 0;  // streams: mean bytes between stalls, per direction; 0: none
  int64_t stall_ns = 0;            // streams: duration of a stall
  uint64_t reset_after_bytes = 0;  // streams: mean bytes until a reset, both directions; 0: none
  size_t mtu = 0;                  // datagrams: longer ones are lost, without a word; 0: none
  bool down = false;               // link down: datagrams are dropped, streams stop
  uint64_t seed = 1;
};

struct RelayCounts {
  uint64_t passed = 0;  // datagrams
  uint64_t passed_bytes = 0;
  uint64_t lost = 0;
  uint64_t duplicated = 0;
  uint64_t reordered = 0;
  uint64_t connections = 0;  // streams
  uint64_t bytes = 0;
  uint64_t stalls = 0;
  uint64_t resets = 0;
};

class DatagramChannel {
 public:
  explicit DatagramChannel(uint64_t seed = 1) : generator_(seed) {}

  struct Fate {
    int copies = 0;  // 0: dropped
    bool overtakes = false;
    int64_t due_ns = 0;
  };
  // Draws the fate of a datagram that arrives now; now_ns must not decrease.
  Fate draw(const Impairment& impairment, size_t bytes, int64_t now_ns);

 private:
  double chance() { return std::uniform_real_distribution<double>(0, 1)(generator_); }

  std::mt19937_64 generator_;
  int64_t free_at_ns_ = 0;  // when the rate-limited link has sent its queue
};

class StreamImpairment {
 public:
  // connection: index among the relay's connections, from 0. to_target: direction.
  StreamImpairment(const Impairment& impairment, uint64_t connection, bool to_target);

  // Returns the number of bytes until the next event.
  uint64_t quiet_bytes() const;
  // Records passed bytes, at most quiet_bytes(). Returns true when the stream stalls here.
  bool pass(uint64_t bytes);
  bool is_reset() const { return until_reset_ == 0; }

  // Draws the delay of one segment; call it once per segment.
  int64_t delay_ns(const Impairment& impairment);

 private:
  uint64_t draw_bytes(uint64_t mean);

  std::mt19937_64 generator_, jitter_;
  uint64_t stall_after_bytes_;
  uint64_t until_stall_ = UINT64_MAX, until_reset_ = UINT64_MAX;
};

struct Outage {
  int64_t begin_ns = 0, end_ns = 0;
};

// Parses "AT:FOR" in seconds, for example 5:2.5. Returns nothing for other text.
std::optional<Outage> parse_outage(const std::string& text);

bool is_down(const std::vector<Outage>& outages, int64_t since_start_ns);

}  // namespace fire3dv::impair
