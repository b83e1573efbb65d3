// Fuzz target of recordings: an arbitrary file is read to its end, checked, played and recovered; the
// recovered file is valid.
#include "base/error.h"
#include "protocol/record/damage.h"
#include "protocol/record/playback.h"
#include "tests/fuzz/target.h"
#include "tests/unit/protocol/record/record_files.h"

namespace fire3dv::fuzz {

std::vector<Input> seeds() {
  std::vector<Input> inputs;
  for (const auto compression :
       {record::Compression::none, record::Compression::zstd, record::Compression::lz4}) {
    const record::Bytes file = record_test::small_recording(compression, 12, 1024);
    const auto* data = reinterpret_cast<const uint8_t*>(file.data());
    inputs.emplace_back(data, data + file.size());
  }
  return inputs;
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv;
  const auto bytes = std::as_bytes(std::span(data, size));
  const record::Bytes file(bytes.begin(), bytes.end());
  const record::ReadLimits limits{4 << 20};
  auto reader = record::Reader::open(std::make_unique<record::MemorySource>(file), limits);
  if (!reader) {
    FIRE3DV_ASSERT(!reader.error().message.empty());
    return 0;
  }
  const size_t messages = record_test::all_messages(*reader).size();
  const auto report = record::verify(*reader, [](const record::Message&) {});
  if (report.ok())
    FIRE3DV_ASSERT(report->messages == messages && report->sound() == report->problems.empty());

  reader->rewind();
  record::Bytes whole;
  const auto recovered = record::recover(*reader, std::make_unique<record::MemorySink>(whole));
  if (recovered.ok()) {
    FIRE3DV_ASSERT(recovered->messages == messages);
    auto again = record::Reader::open(std::make_unique<record::MemorySource>(whole), limits);
    const bool is_whole =
        recovered->messages != 0 || recovered->attachments != 0;  // of nothing there is no file
    FIRE3DV_ASSERT(again.ok() && again->index().has_summary == is_whole);
    FIRE3DV_ASSERT(record_test::all_messages(*again).size() == messages);
  }

  auto playback = record::Playback::open(std::make_unique<record::MemorySource>(file), limits);
  if (!playback) return 0;
  record::Played played;
  for (const uint64_t at_ns :
       {playback->start_ns(), playback->start_ns() / 2 + playback->end_ns() / 2, UINT64_MAX}) {
    playback->seek(at_ns);
    while (playback->next(played) != record::Playback::Step::end) FIRE3DV_ASSERT(played.stream < 1024);
  }
  return 0;
}
