// OpenSSL's source and sink of single datagrams, in memory. Each read takes one whole datagram and each write
// makes one, which BIO_s_mem does not keep apart; BIO_s_dgram_mem does, from OpenSSL 3.2 on.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

struct bio_st;

namespace fire3dv::transport::udp {

struct DatagramEnds {
  // The datagram that the next read takes; later ones find nothing.
  std::span<const std::byte> incoming;
  // Where the next record of application data is written, so that sealing one takes no memory.
  std::span<std::byte> sealed;
  size_t sealed_bytes = 0;
  // All other datagrams that were written, but alerts: nobody heeds those.
  std::vector<std::vector<std::byte>> outgoing;
};

// Null: no memory. `ends` has to outlive it.
bio_st* make_datagram_bio(DatagramEnds& ends);

}  // namespace fire3dv::transport::udp
