// Certificates and keys for tests, made on the spot and good for an hour.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

namespace fire3dv::test {

// A folder of its own under the system's temporary one, removed at the end.
class Credentials {
 public:
  Credentials();
  ~Credentials();
  Credentials(const Credentials&) = delete;
  Credentials& operator=(const Credentials&) = delete;

  struct Identity {
    std::string certificate_file, key_file;
  };
  // A certificate authority; its key file signs.
  Identity authority(const std::string& name) const;
  // A certificate of these hosts ("DNS:example.org,IP:127.0.0.1"), signed by the authority.
  Identity identity(const std::string& name, const std::string& hosts, const Identity& signer) const;
  // A file with this text and this mode.
  std::string file(const std::string& name, const std::string& text, unsigned mode) const;
  // A pre-shared key, 64 times this digit, that nobody else can read.
  std::string key(const std::string& name, char digit) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace fire3dv::test
