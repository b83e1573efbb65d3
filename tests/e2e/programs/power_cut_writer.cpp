// Writer for tests of power cuts: power_cut_writer FOLDER FRAMES FLUSH_MS. It records one frame per
// millisecond of its own clock to run.mcap, and replaces the file replaced/settings every 25 frames. After
// each step it appends the number of frames and of replacements (8 bytes each) to the file progress: the
// steps completed before the cut.
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "base/files.h"
#include "tests/unit/protocol/record/record_files.h"

namespace {

using namespace fire3dv;
using namespace fire3dv::record_test;

constexpr uint64_t kFramesPerReplacement = 25;

bool failed(const Result<void>& done) {
  if (!done) std::fprintf(stderr, "power_cut_writer: %s\n", done.error().message.c_str());
  return !done;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const std::string folder = argv[1];
  const uint64_t frames = std::strtoull(argv[2], nullptr, 10);
  const int progress = ::open((folder + "/progress").c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (progress < 0) return 1;
  record::LogOptions options = small_chunks(2000);
  options.flush_ns = std::strtoull(argv[3], nullptr, 10) * kMs;
  record::StreamLog log([&](uint32_t) { return record::create_sink(folder + "/run.mcap"); }, {}, options);
  if (failed(log.take(1, description(7), kBegun_ns))) return 1;
  std::array<uint64_t, 2> done{};
  for (uint64_t i = 1; i <= frames; ++i) {
    if (failed(log.take(1, frame(7, i), kBegun_ns + i * kMs))) return 1;
    done[0] = i;
    if (i % kFramesPerReplacement == 0) {
      const std::string number = std::to_string(done[1] + 1) + "\n";
      std::string text;
      while (text.size() < 5000) text += number;
      if (failed(base::write_atomically(folder + "/replaced/settings", {std::as_bytes(std::span(text))})))
        return 1;
      ++done[1];
    }
    if (::write(progress, done.data(), sizeof done) != sizeof done) return 1;
  }
  return failed(log.finish()) ? 1 : 0;
}
