// A network of the test's own, so that no test sends a byte to a real one: a namespace with loopback and one
// more interface, on which multicast and link-local addresses work as on any other.
#pragma once

#include <gtest/gtest.h>

#include <string>

namespace fire3dv::transport::test {

class OwnNetwork : public testing::Environment {
 public:
  static constexpr const char* kLinkLocal = "fe80::f3d";

  // Before any thread is started. Where namespaces are not allowed the machine's own interfaces have to do.
  void SetUp() override;
  static const std::string& interface();
};

}  // namespace fire3dv::transport::test
