#include "protocol/record/gaps.h"

#include "base/plural.h"
#include "base/text.h"

namespace fire3dv::record {
namespace {

constexpr size_t kMaxNamedStreams = 8;

}  // namespace

std::optional<std::string> describe_gaps(const LogStatus& status) {
  std::string text;
  size_t named = 0, unnamed = 0;
  for (const StreamSeen& stream : status.streams) {
    if (stream.missing == 0 && stream.incomplete == 0) continue;
    if (named++ >= kMaxNamedStreams) {
      ++unnamed;
      continue;
    }
    if (!text.empty()) text += "; ";
    text += "stream \"" + terminal_text(stream.name) + "\" lacks " + counted(stream.missing, "frame") +
            " of " + std::to_string(stream.frames + stream.missing);
    if (stream.incomplete != 0) text += ", and " + counted(stream.incomplete, "frame") + " in part";
  }
  if (unnamed != 0) text += "; and " + counted(unnamed, "more stream");
  if (status.reclaimed_missing != 0) {
    if (!text.empty()) text += "; ";
    text += "streams that ended earlier lack " + counted(status.reclaimed_missing, "frame");
  }
  if (text.empty()) return {};
  return text +
         ": they were lost on the way, or not read in time (use tcp or tls instead of udp, or a machine "
         "with less load)";
}

}  // namespace fire3dv::record
