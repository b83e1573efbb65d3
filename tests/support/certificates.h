// Certificates and keys for tests, generated at run time and valid for an hour.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

namespace fire3dv::test {

// A private temporary folder, removed at the end.
class Credentials {
 public:
  Credentials();
  ~Credentials();
  Credentials(const Credentials&) = delete;
  Credentials& operator=(const Credentials&) = delete;

  struct Identity {
    std::string certificate_file, key_file;
  };
  // Creates a certificate authority; its key signs identities.
  Identity authority(const std::string& name) const;
  // Creates a certificate for these hosts ("DNS:example.org,IP:127.0.0.1"), signed by the authority.
  Identity identity(const std::string& name, const std::string& hosts, const Identity& signer) const;
  // Writes a file with this text and this mode.
  std::string file(const std::string& name, const std::string& text, unsigned mode) const;
  // Writes a pre-shared key, 64 times this digit, readable by its owner only.
  std::string key(const std::string& name, char digit) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace fire3dv::test
