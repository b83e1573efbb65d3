// The pre-shared key of a UDP link: who has it may have a session, and each session has keys of its own, one
// for each direction, from the randoms of both sides. A counter never meets the same key twice, however often
// either side starts.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "protocol/error.h"
#include "protocol/transport/secret.h"
#include "protocol/transport/udp_datagram.h"

namespace fire3dv::transport::udp {

using Random = std::array<std::byte, 32>;
using Proof = std::array<std::byte, 32>;
Random make_random();

// Seals and opens the datagrams of one side of one session (ChaCha20-Poly1305; the header is authenticated
// with them).
class Seal {
 public:
  using Key = std::array<unsigned char, 32>;
  Seal(const Key& own, const Key& others) : own_(own), others_(others) {}
  ~Seal();
  Seal(const Seal&) = delete;
  Seal& operator=(const Seal&) = delete;

  // `datagram` has kTagBytes of room behind `bytes`. Returns the sealed length.
  size_t seal(std::byte* datagram, size_t bytes, uint64_t counter) const;
  // Opens in place; nothing when it was not sealed by the other side of this session.
  std::optional<std::span<const std::byte>> open(std::span<std::byte> datagram, uint64_t counter) const;

 private:
  Key own_, others_;
};

class PreSharedKey {
 public:
  enum class Side { publisher, listener };

  static Result<std::shared_ptr<const PreSharedKey>> from_file(const std::string& path);
  explicit PreSharedKey(const Secret& key);
  ~PreSharedKey();
  PreSharedKey(const PreSharedKey&) = delete;
  PreSharedKey& operator=(const PreSharedKey&) = delete;

  // Says that whoever wrote `message`, in answer to `about`, has the key.
  Proof prove(std::span<const std::byte> message, std::span<const std::byte> about = {}) const;
  bool check(const Proof& proof, std::span<const std::byte> message,
             std::span<const std::byte> about = {}) const;

  std::unique_ptr<Seal> make_seal(Side side, uint64_t session, const Random& publishers,
                                  const Random& listeners) const;

 private:
  std::array<unsigned char, 32> proof_key_, session_key_;
};

}  // namespace fire3dv::transport::udp
