// Model check of the shared-memory ring: all executions that the C++ memory model allows a reader, with a
// writer killed after any store. Mutations prove that each memory order, fence, load and store is necessary:
// without one of them the search finds a fault.
#include <gtest/gtest.h>

#include <cstdio>
#include <set>
#include <string>

#include "tests/unit/protocol/transport/shm/ring_model.h"

namespace fire3dv::transport::test {
namespace {

using shm::published_step;
using shm::read_steps;
using shm::ReadOutcome;

constexpr uint64_t kCapacity = 1 << 20;

struct Faults {
  Fault write, read, ask;  // ask: load of the newest message number
};

struct Findings {
  uint64_t ways = 0;            // executions of reads
  uint64_t accepted = 0;        // of these
  uint64_t wrong = 0;           // accepted with wrong contents
  uint64_t corrupt = 0;         // false reports of corruption
  uint64_t lapped_wrongly = 0;  // published, not overwritten, and unreadable
  uint64_t lost = 0;            // whole, but unreadable after a crash

  uint64_t faults() const { return wrong + corrupt + lapped_wrongly + lost; }
};

bool is_message(const Shape& shape, uint64_t number, uint64_t tag, const std::vector<uint64_t>& words) {
  bool good = tag == tag_of_message(number) && 8 * words.size() == bytes_of_message(shape, number);
  for (uint64_t i = 0; good && i < words.size(); ++i) good = words[i] == word_of_message(number, i);
  return good;
}

// A reader that repeatedly asks for the newest number and then for any message, with all knowledge of earlier
// calls. Reads of guessed numbers must be correct, too.
void go_through_reads(const Shape& shape, const WrittenRing& ring, uint64_t messages, const Faults& faults,
                      Findings& findings) {
  ModelReader asker(shape, ring, ring.stores().size(), faults.ask);
  ModelReader reader(shape, ring, ring.stores().size(), faults.read);
  const Knowledge nothing{View(shape.places(), 0), View(shape.places(), 0)};
  std::set<Knowledge> seen{nothing};
  std::vector<Knowledge> open{nothing};
  // Stops at the first fault: behind it the search may not terminate.
  while (!open.empty() && findings.faults() == 0) {
    const Knowledge before = std::move(open.back());
    open.pop_back();
    asker.all_ways(before, 1, [&] {
      const uint64_t published = published_step(asker);
      for (uint64_t number = 1; number <= messages; ++number) {
        reader.all_ways(asker.knows, number, [&] {
          uint64_t tag = 0;
          const ReadOutcome outcome = read_steps(reader, number, kCapacity, tag);
          ++findings.ways;
          findings.corrupt += outcome == ReadOutcome::corrupt;
          if (outcome == ReadOutcome::ok) {
            ++findings.accepted;
            findings.wrong += !is_message(shape, number, tag, reader.copied);
          } else {
            findings.lapped_wrongly += number <= published && reader.seen_sequence <= 2 * number;
          }
          if (seen.insert(reader.knows).second) open.push_back(reader.knows);
        });
      }
    });
  }
}

// Kills the writer after each of its stores; a reader starts afterwards.
void go_through_crashes(const Shape& shape, const WrittenRing& ring, uint64_t messages, const Faults& faults,
                        Findings& findings) {
  const Knowledge nothing{View(shape.places(), 0), View(shape.places(), 0)};
  for (size_t done = 0; done <= ring.stores().size(); ++done) {
    ModelReader reader(shape, ring, done, faults.read);
    uint64_t published = 0;
    reader.newest_way(nothing, 1, [&] { published = published_step(reader); });
    if (done == ring.stores().size()) findings.lost += published != messages;
    // All slots but one hold whole messages; that one may have been half written.
    for (uint64_t number = published; number > 0 && published - number < shape.slots - 1; --number) {
      reader.newest_way(nothing, number, [&] {
        uint64_t tag = 0;
        const bool whole = read_steps(reader, number, kCapacity, tag) == ReadOutcome::ok &&
                           is_message(shape, number, tag, reader.copied);
        findings.lost += !whole;
      });
    }
  }
}

Findings go_through(const Shape& shape, uint64_t messages, const Faults& faults) {
  const WrittenRing ring(shape, messages, faults.write);
  Findings findings;
  go_through_reads(shape, ring, messages, faults, findings);
  go_through_crashes(shape, ring, messages, faults, findings);
  return findings;
}

void expect_sound(const Shape& shape, uint64_t messages) {
  const Findings findings = go_through(shape, messages, {});
  EXPECT_EQ(findings.wrong, 0u);
  EXPECT_EQ(findings.corrupt, 0u);
  EXPECT_EQ(findings.lapped_wrongly, 0u);
  EXPECT_EQ(findings.lost, 0u);
  EXPECT_GT(findings.accepted, messages) << "what is never accepted cannot be wrong";
  EXPECT_GT(findings.ways, findings.accepted) << "no reader was ever overtaken: the search is too small";
  std::printf("%llu slots, %llu messages: %llu reads, %llu of them accepted\n",
              static_cast<unsigned long long>(shape.slots), static_cast<unsigned long long>(messages),
              static_cast<unsigned long long>(findings.ways),
              static_cast<unsigned long long>(findings.accepted));
}

TEST(ShmModel, TwoSlotsAreSound) {
  expect_sound({2, 2}, 6);
}

TEST(ShmModel, FourSlotsAreSound) {
  expect_sound({4, 2}, 7);
}

TEST(ShmModel, WriteStepsAreIndependent) {
  const int steps = WrittenRing({2, 2}, 1, {}).steps_of_a_write();
  EXPECT_EQ(WrittenRing({2, 2}, 9, {}).steps_of_a_write(), steps);
}

// --- necessity

const Shape kSmall{2, 2};
constexpr uint64_t kFew = 4;

TEST(ShmModel, EachWriteStepMatters) {
  const int steps = WrittenRing(kSmall, 1, {}).steps_of_a_write();
  EXPECT_EQ(steps, 7);
  for (int step = 0; step < steps; ++step) {
    const Findings findings =
        go_through(kSmall, kFew, {.write = {Fault::Kind::leave_out, step}, .read = {}, .ask = {}});
    EXPECT_GT(findings.faults(), 0u) << "step " << step << " is left out and nothing is found";
  }
}

TEST(ShmModel, EachReadStepMatters) {
  const WrittenRing ring(kSmall, kFew, {});
  ModelReader reader(kSmall, ring, ring.stores().size(), {});
  const Knowledge nothing{View(kSmall.places(), 0), View(kSmall.places(), 0)};
  uint64_t tag = 0;
  reader.newest_way(nothing, kFew,
                    [&] { EXPECT_EQ(read_steps(reader, kFew, kCapacity, tag), ReadOutcome::ok); });
  EXPECT_EQ(reader.steps(), 6);
  for (int step = 0; step < reader.steps(); ++step) {
    const Findings findings =
        go_through(kSmall, kFew, {.write = {}, .read = {Fault::Kind::leave_out, step}, .ask = {}});
    EXPECT_GT(findings.faults(), 0u) << "step " << step << " is left out and nothing is found";
  }
}

// Memory orders of the stores of sequence and newest number, the first load of the sequence, and the load of
// the newest number. (Fences are separate steps.)
TEST(ShmModel, EveryOrderIsNeeded) {
  const Fault ends_write{Fault::Kind::relax, 5}, publishes{Fault::Kind::relax, 6},
      looks{Fault::Kind::relax, 0};
  EXPECT_GT(go_through(kSmall, kFew, {.write = ends_write, .read = {}, .ask = {}}).wrong, 0u);
  EXPECT_GT(go_through(kSmall, kFew, {.write = publishes, .read = {}, .ask = {}}).lapped_wrongly, 0u);
  EXPECT_GT(go_through(kSmall, kFew, {.write = {}, .read = looks, .ask = {}}).wrong, 0u);
  EXPECT_GT(go_through(kSmall, kFew, {.write = {}, .read = {}, .ask = looks}).lapped_wrongly, 0u);
}

// With one slot a crash during a write leaves no whole message: a ring needs at least two.
TEST(ShmModel, OneSlotIsTooFew) {
  const Shape shape{1, 2};
  const WrittenRing ring(shape, 2, {});
  const Knowledge nothing{View(shape.places(), 0), View(shape.places(), 0)};
  bool lost = false;
  for (size_t done = 0; done <= ring.stores().size(); ++done) {
    ModelReader reader(shape, ring, done, {});
    uint64_t published = 0, tag = 0;
    reader.newest_way(nothing, 1, [&] { published = published_step(reader); });
    if (published == 0) continue;
    reader.newest_way(nothing, published, [&] {
      lost = lost || read_steps(reader, published, kCapacity, tag) != ReadOutcome::ok;
    });
  }
  EXPECT_TRUE(lost);
}

}  // namespace
}  // namespace fire3dv::transport::test
