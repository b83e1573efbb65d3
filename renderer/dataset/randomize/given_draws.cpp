#include "renderer/dataset/randomize/given_draws.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "base/digest.h"
#include "base/files.h"
#include "base/text.h"
#include "base/words.h"

namespace fire3dv::dataset {
namespace {

constexpr uint64_t kMaxDrawsBytes = uint64_t{1} << 30;

// nullopt: neither a number, a text, nor up to four numbers.
std::optional<DrawnValue> read_value(const nlohmann::json& value) {
  if (value.is_string()) return DrawnValue{{}, value.get<std::string>()};
  if (value.is_number()) return DrawnValue{{value.get<double>()}, {}};
  if (!value.is_array() || value.empty() || value.size() > 4) return {};
  DrawnValue result;
  for (const auto& part : value) {
    if (!part.is_number()) return {};
    result.numbers.push_back(part.get<double>());
  }
  return result;
}

}  // namespace

Result<GivenDraws> read_given_draws(const std::filesystem::path& file) {
  auto bytes = read_whole_file(file, kMaxDrawsBytes);
  if (!bytes) return bytes.error();
  GivenDraws given;
  given.file = printable_text(file.string(), 1000);
  given.digest = hex(digest_of(std::as_bytes(std::span(*bytes)))).substr(0, 32);
  std::string_view left(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  for (size_t number = 1; !left.empty(); ++number) {
    const size_t end = std::min(left.find('\n'), left.size());
    const std::string_view text = left.substr(0, end);
    left.remove_prefix(std::min(end + 1, left.size()));
    if (trimmed(text).empty()) continue;
    const std::string at = given.file + ":" + std::to_string(number) + ": ";
    const auto line = nlohmann::json::parse(text, nullptr, false);
    const auto image = line.is_object() ? line.find("frame") : line.end();
    const auto drawn = line.is_object() ? line.find("drawn") : line.end();
    if (!line.is_object() || image == line.end() || !image->is_number_unsigned() || drawn == line.end() ||
        !drawn->is_object())
      return Error{at + R"(a line is {"frame": IMAGE, "drawn": {"NAME": VALUE}})"};
    for (const auto& [name, value] : drawn->items()) {
      auto read = read_value(value);
      if (!read) return Error{at + quote(name) + " must be a number, a text, or up to four numbers"};
      given.images[image->get<uint64_t>()][name] = std::move(*read);
    }
  }
  return given;
}

}  // namespace fire3dv::dataset
