// Test of the choice of the connection that makes room for another.
#include "protocol/transport/http/accept_loop.h"

#include <gtest/gtest.h>

namespace fire3dv::transport::http {
namespace {

using Use = OpenConnection::Use;

class ChooseEvicted : public ::testing::Test {
 protected:
  void add(const std::string& client, Use use) {
    open_.push_back({client, start_ + std::chrono::seconds(open_.size()), use, {}});
  }
  int chosen_for(const std::string& newcomer) const {
    const OpenConnection* const chosen = choose_evicted(open_, newcomer);
    return chosen ? static_cast<int>(chosen - open_.data()) : -1;
  }
  std::chrono::steady_clock::time_point start_;
  std::vector<OpenConnection> open_;
};

TEST_F(ChooseEvicted, OldestOfClientWithMost) {
  add("honest", Use::idle);
  for (int i = 0; i < 5; ++i) add("flood", Use::idle);
  EXPECT_EQ(chosen_for("honest"), 1);
  EXPECT_EQ(chosen_for("flood"), 1);
  EXPECT_EQ(chosen_for("another"), 1);
}

TEST_F(ChooseEvicted, OnlyOneClientLosesItsOldest) {
  for (int i = 0; i < 3; ++i) add("one", Use::idle);
  EXPECT_EQ(chosen_for("one"), 0);
}

TEST_F(ChooseEvicted, ReceivingGivesWayToOtherClientsOnly) {
  for (int i = 0; i < 4; ++i) add("flood", Use::receiving);
  EXPECT_EQ(chosen_for("flood"), -1);
  EXPECT_EQ(chosen_for("honest"), 0);
  open_[2].use = Use::slow;
  EXPECT_EQ(chosen_for("flood"), 2);
}

TEST_F(ChooseEvicted, KeptStay) {
  for (int i = 0; i < 4; ++i) add("viewer", Use::kept);
  EXPECT_EQ(chosen_for("honest"), -1);
  add("other", Use::idle);
  EXPECT_EQ(chosen_for("honest"), 4);
}

}  // namespace
}  // namespace fire3dv::transport::http
