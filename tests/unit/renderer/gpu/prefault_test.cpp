// Test of memory prefaulting: pages become resident, and their contents stay, also with concurrent writers.
#include "renderer/gpu/device/resources.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

namespace fire3dv::gpu {
namespace {

class Prefault : public ::testing::Test {
 protected:
  static constexpr size_t kBytes = size_t{64} << 20;

  void SetUp() override {
    const int file = memfd_create("touch_ahead_test", 0);
    ASSERT_EQ(ftruncate(file, kBytes), 0);
    void* const mapped = mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    ::close(file);
    ASSERT_NE(mapped, MAP_FAILED);
    memory_ = {static_cast<std::byte*>(mapped), kBytes};
#ifdef MADV_POPULATE_WRITE
    void* const page = mmap(nullptr, page_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    can_ = madvise(page, page_, MADV_POPULATE_WRITE) == 0;
    munmap(page, page_);
#endif
  }
  void TearDown() override {
    munmap(memory_.data(), memory_.size());
  }

  size_t pages_present() const {
    std::vector<unsigned char> present(kBytes / page_);
    EXPECT_EQ(mincore(memory_.data(), kBytes, present.data()), 0);
    return static_cast<size_t>(
        std::count_if(present.begin(), present.end(), [](unsigned char p) { return p & 1; }));
  }

  std::span<std::byte> memory_;
  const size_t page_ = static_cast<size_t>(sysconf(_SC_PAGESIZE));
  bool can_ = false;  // supported by the system
};

TEST_F(Prefault, WholePagesOfThePieces) {
  // Three pages and parts of two; four pages; none.
  prefault({memory_.subspan(100, 4 * page_), memory_.subspan(16 * page_, 4 * page_),
            memory_.subspan(32 * page_, 10)})
      .join();
  // More with larger pages of a file's memory; none without system support.
  const size_t present = pages_present();
  EXPECT_TRUE(can_ ? present >= 3 + 4 : present == 0) << present;
  prefault({memory_}).join();
  EXPECT_EQ(pages_present(), can_ ? kBytes / page_ : 0u);
}

TEST_F(Prefault, WhatIsWrittenMeanwhileStays) {
  {
    const std::jthread touching = prefault({memory_});
    for (size_t i = 0; i < kBytes; i += page_) std::memcpy(&memory_[i], &i, sizeof(i));
  }
  prefault({memory_}).join();
  for (size_t i = 0; i < kBytes; i += page_) ASSERT_EQ(std::memcmp(&memory_[i], &i, sizeof(i)), 0) << i;
}

TEST_F(Prefault, NothingToTouch) {
  prefault({}).join();
  prefault({std::span<std::byte>{}}).join();
  EXPECT_EQ(pages_present(), 0u);
}

}  // namespace
}  // namespace fire3dv::gpu
