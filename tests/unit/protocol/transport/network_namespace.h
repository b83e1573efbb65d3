// Private network namespace of a test program, so that no test sends a byte to a real network. It has
// loopback and one more interface with multicast and link-local addresses.
#pragma once

#include <gtest/gtest.h>

#include <string>

namespace fire3dv::transport::test {

class OwnNetwork : public testing::Environment {
 public:
  static constexpr const char* kLinkLocal = "fe80::f3d";

  // Call before any thread starts. Without the right to create namespaces the machine's interfaces are used.
  void SetUp() override;
  static const std::string& interface();
};

}  // namespace fire3dv::transport::test
