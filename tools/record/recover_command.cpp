#include "tools/record/recover_command.h"

#include <cstdint>
#include <cstdio>

#include "protocol/base/text.h"
#include "protocol/record/recover.h"

namespace fire3dv::record {
namespace {

int fail(const Error& error) {
  std::fprintf(stderr, "fire3dv-record: %s\n", terminal_text(error.message).c_str());
  return 1;
}

}  // namespace

int recover_file(const RecoverOptions& options) {
  auto source = open_source(options.from);
  if (!source) return fail(source.error());
  auto reader = Reader::open(std::move(*source), {options.memory_mb << 20});
  if (!reader) return fail(reader.error());
  auto sink = create_atomic_sink(options.to);
  if (!sink) return fail(sink.error());
  const auto result = recover(*reader, std::move(*sink));
  if (!result) return fail(result.error());
  std::printf(
      "%llu messages of %llu whole chunks and %llu attachments; %llu chunks and %llu attachments were "
      "damaged\n",
      static_cast<unsigned long long>(result->messages), static_cast<unsigned long long>(result->chunks),
      static_cast<unsigned long long>(result->attachments),
      static_cast<unsigned long long>(result->damaged_chunks),
      static_cast<unsigned long long>(result->damaged_attachments));
  if (const uint64_t loose = reader->index().loose_messages; loose != 0)
    std::printf("%llu messages outside of chunks were skipped\n", static_cast<unsigned long long>(loose));
  if (!result->first_damage.empty())
    std::printf("first damage: %s\n", terminal_text(result->first_damage).c_str());
  return 0;
}

}  // namespace fire3dv::record
