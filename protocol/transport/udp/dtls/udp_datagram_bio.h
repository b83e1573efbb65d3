// In-memory datagram BIO for OpenSSL: each read consumes one datagram and each write produces one. BIO_s_mem
// does not preserve datagram boundaries; BIO_s_dgram_mem does, but needs OpenSSL 3.2.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

struct bio_st;

namespace fire3dv::transport::udp {

struct DatagramEnds {
  // Datagram of the next read; later reads return "retry".
  std::span<const std::byte> incoming;
  // Destination of the next application data record, so that sealing does not allocate.
  std::span<std::byte> sealed;
  size_t sealed_bytes = 0;
  // All other written datagrams except alerts, which both sides ignore.
  std::vector<std::vector<std::byte>> outgoing;
};

// Returns null if out of memory. `ends` must outlive the BIO.
bio_st* make_datagram_bio(DatagramEnds& ends);

}  // namespace fire3dv::transport::udp
