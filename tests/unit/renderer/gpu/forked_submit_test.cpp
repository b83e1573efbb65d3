// Model check of frames that fork to the async compute queue: enumerates every execution order of two queues,
// so that no timing hides a missing wait.
#include "renderer/gpu/device/queues.h"

#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>

namespace fire3dv::gpu {
namespace {

template <typename Handle>
Handle fake(uintptr_t number) {
  return reinterpret_cast<Handle>(number);
}
const auto kForkTimeline = fake<VkSemaphore>(1), kFrameTimeline = fake<VkSemaphore>(2);

enum Piece : uint32_t { kBefore, kAside, kBeside, kAfter };
uint32_t batch_of(uint32_t frame, Piece piece) {
  return 4 * frame + piece;
}

// Vulkan's execution model. Batches of a queue start in submission order, after the waits of all earlier
// batches. They end in any order. A signal waits for the end of its batch and of all before it.
class Queues {
 public:
  void submit(uint32_t queue, std::span<const VkSubmitInfo2> submits) {
    for (const VkSubmitInfo2& submit : submits) {
      Batch batch{queue, {}, {}};
      for (uint32_t i = 0; i < submit.waitSemaphoreInfoCount; ++i) {
        const VkSemaphoreSubmitInfo& wait = submit.pWaitSemaphoreInfos[i];
        batch.waits.emplace_back(wait.semaphore, wait.value);
      }
      for (uint32_t i = 0; i < submit.signalSemaphoreInfoCount; ++i) {
        const VkSemaphoreSubmitInfo& signal = submit.pSignalSemaphoreInfos[i];
        batch.signals.emplace_back(signal.semaphore, signal.value);
      }
      ASSERT_EQ(submit.commandBufferInfoCount, 1u);
      const auto number = reinterpret_cast<uintptr_t>(submit.pCommandBufferInfos[0].commandBuffer);
      order_.push_back(static_cast<uint32_t>(number - 1));
      batches_[order_.back()] = batch;
    }
  }

  struct State {
    uint32_t started = 0, ended = 0;
    auto operator<=>(const State&) const = default;
    bool has_started(uint32_t batch) const { return started >> batch & 1; }
    bool has_ended(uint32_t batch) const { return ended >> batch & 1; }
  };

  // Returns all reachable states. A state without a successor before the end of all batches is a deadlock.
  std::set<State> all_states() const {
    std::set<State> seen{State{}};
    std::deque<State> open{State{}};
    while (!open.empty()) {
      const State state = open.front();
      open.pop_front();
      bool stuck = true;
      for (const auto& [batch, description] : batches_) {
        State next = state;
        if (can_start(state, batch)) next.started |= 1u << batch;
        if (state.has_started(batch)) next.ended |= 1u << batch;
        if (next == state) continue;
        stuck = false;
        if (seen.insert(next).second) open.push_back(next);
      }
      EXPECT_TRUE(!stuck || state.ended == (1u << batches_.size()) - 1) << "hangs";
    }
    return seen;
  }

 private:
  struct Batch {
    uint32_t queue;
    std::vector<std::pair<VkSemaphore, uint64_t>> waits, signals;
  };

  // True if the predicate holds for all batches of the same queue up to this one.
  bool all_up_to(uint32_t batch, const std::function<bool(uint32_t)>& fulfil) const {
    for (const uint32_t earlier : order_) {
      if (batches_.at(earlier).queue != batches_.at(batch).queue) continue;
      if (!fulfil(earlier)) return false;
      if (earlier == batch) return true;
    }
    return true;
  }
  uint64_t value(const State& state, VkSemaphore semaphore) const {
    uint64_t value = 0;
    for (const auto& [batch, description] : batches_) {
      for (const auto& [signalled, to] : description.signals) {
        if (signalled == semaphore && all_up_to(batch, [&](uint32_t b) { return state.has_ended(b); }))
          value = std::max(value, to);
      }
    }
    return value;
  }
  bool can_start(const State& state, uint32_t batch) const {
    return !state.has_started(batch) && all_up_to(batch, [&](uint32_t earlier) {
      if (earlier != batch && !state.has_started(earlier)) return false;
      for (const auto& [semaphore, at_least] : batches_.at(earlier).waits) {
        if (value(state, semaphore) < at_least) return false;
      }
      return true;
    });
  }

  std::map<uint32_t, Batch> batches_;
  std::vector<uint32_t> order_;
};

Queues submitted(uint32_t frames, uint32_t async_queue) {
  Queues queues;
  for (uint32_t frame = 0; frame < frames; ++frame) {
    auto commands = [&](Piece piece) { return fake<VkCommandBuffer>(batch_of(frame, piece) + 1); };
    const ForkedSubmit fork({commands(kBefore), commands(kAside), commands(kBeside), commands(kAfter)},
                            kForkTimeline, frame + 1, {}, {semaphore_submit(kFrameTimeline, frame + 1)});
    queues.submit(0, {&fork.before(), 1});
    queues.submit(async_queue, {&fork.async_compute(), 1});
    queues.submit(0, fork.rest());
  }
  return queues;
}

TEST(ForkedSubmit, PiecesWaitForInputs) {
  for (const Queues::State& state : submitted(2, 1).all_states()) {
    for (uint32_t frame = 0; frame < 2; ++frame) {
      if (state.has_started(batch_of(frame, kAside))) {
        EXPECT_TRUE(state.has_ended(batch_of(frame, kBefore)))
            << "the async piece does not wait for the first one";
      }
      if (state.has_started(batch_of(frame, kAfter))) {
        EXPECT_TRUE(state.has_ended(batch_of(frame, kAside))) << "what is after does not wait for it";
      }
    }
  }
}

TEST(ForkedSubmit, NextFrameOverwritesNothingRead) {
  for (const Queues::State& state : submitted(2, 1).all_states()) {
    if (state.has_started(batch_of(1, kBefore))) {
      EXPECT_TRUE(state.has_ended(batch_of(0, kAside))) << "instances are written while they are read";
    }
    if (state.has_started(batch_of(1, kAside))) {
      EXPECT_TRUE(state.has_ended(batch_of(0, kAfter))) << "the top level is built while rays meet it";
    }
  }
}

TEST(ForkedSubmit, QueuesRunConcurrently) {
  bool together = false, beside_first = false, aside_first = false;
  for (const Queues::State& state : submitted(1, 1).all_states()) {
    together |= state.has_started(kAside) && !state.has_ended(kAside) && state.has_started(kBeside) &&
                !state.has_ended(kBeside);
    beside_first |= state.has_ended(kBeside) && !state.has_started(kAside);
    aside_first |= state.has_ended(kAside) && !state.has_started(kBeside);
  }
  EXPECT_TRUE(together);
  EXPECT_TRUE(beside_first);
  EXPECT_TRUE(aside_first);
}

TEST(ForkedSubmit, SingleQueueDoesNotHang) {
  const std::set<Queues::State> states = submitted(3, 0).all_states();
  EXPECT_TRUE(states.contains({(1u << 12) - 1, (1u << 12) - 1}));
}

TEST(ForkedSubmit, LastPieceSignalsTheCaller) {
  const auto acquired = fake<VkSemaphore>(7), rendered = fake<VkSemaphore>(8);
  const ForkedSubmit fork({}, kForkTimeline, 5, {semaphore_submit(acquired, 0)},
                          {semaphore_submit(rendered, 0), semaphore_submit(kFrameTimeline, 9)});
  const VkSubmitInfo2& after = fork.rest()[1];
  ASSERT_EQ(after.waitSemaphoreInfoCount, 2u);
  EXPECT_EQ(after.pWaitSemaphoreInfos[0].semaphore, acquired);
  ASSERT_EQ(after.signalSemaphoreInfoCount, 2u);
  EXPECT_EQ(after.pSignalSemaphoreInfos[0].semaphore, rendered);
  EXPECT_EQ(after.pSignalSemaphoreInfos[1].value, 9u);
  EXPECT_EQ(fork.rest()[0].waitSemaphoreInfoCount, 0u);
}

}  // namespace
}  // namespace fire3dv::gpu
