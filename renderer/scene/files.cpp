#include "renderer/scene/files.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <system_error>
#include <utility>

namespace fire3dv::scene {
namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::optional<std::string> percent_decoded(std::string_view text) {
  std::string decoded;
  decoded.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    if (text.size() - i < 3) return std::nullopt;
    const int high = hex_digit(text[i + 1]), low = hex_digit(text[i + 2]);
    if (high < 0 || low < 0) return std::nullopt;
    decoded += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return decoded;
}

constexpr std::array<int8_t, 256> base64_values() {
  std::array<int8_t, 256> values{};
  for (int8_t& value : values) value = -1;
  constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (size_t i = 0; i < alphabet.size(); ++i)
    values[static_cast<uint8_t>(alphabet[i])] = static_cast<int8_t>(i);
  return values;
}

Result<FileBytes> base64_decoded(std::string_view text) {
  static constexpr std::array<int8_t, 256> kValues = base64_values();
  for (int padding = 0; padding < 2 && text.ends_with('='); ++padding) text.remove_suffix(1);
  if (text.size() % 4 == 1) return Error{"its base64 text is cut short"};
  FileBytes bytes;
  bytes.size = text.size() / 4 * 3 + (text.size() % 4 == 0 ? 0 : text.size() % 4 - 1);
  bytes.data = std::make_unique_for_overwrite<std::byte[]>(bytes.size);
  uint32_t bits = 0;
  size_t out = 0;
  for (size_t i = 0; i < text.size(); ++i) {
    const int8_t value = kValues[static_cast<uint8_t>(text[i])];
    if (value < 0) return Error{"its base64 text holds a character that is not base64"};
    bits = bits << 6 | static_cast<uint32_t>(value);
    // Each character after the first of four completes one byte.
    if (i % 4 != 0) bytes.data[out++] = static_cast<std::byte>(bits >> (6 - 2 * (i % 4)));
  }
  return bytes;
}

FileBytes copied(std::string_view text) {
  FileBytes bytes;
  bytes.size = text.size();
  bytes.data = std::make_unique_for_overwrite<std::byte[]>(bytes.size);
  std::memcpy(bytes.data.get(), text.data(), text.size());
  return bytes;
}

// RFC 2397: base64 or percent-encoded bytes.
Result<FileBytes> data_uri_decoded(std::string_view uri) {
  const size_t comma = uri.find(',');
  if (comma == std::string_view::npos) return Error{"the data: URI has no comma"};
  const std::string_view data = uri.substr(comma + 1);
  const bool is_base64 = uri.substr(0, comma).ends_with(";base64");
  if (is_base64 && data.find('%') == std::string_view::npos) return base64_decoded(data);
  const std::optional<std::string> decoded = percent_decoded(data);
  if (!decoded) return Error{"the data: URI has a broken percent escape"};
  return is_base64 ? base64_decoded(*decoded) : copied(*decoded);
}

bool has_scheme(std::string_view uri) {
  const size_t colon = uri.find(':');
  return colon != std::string_view::npos && colon < uri.find('/');
}

}  // namespace

AssetFolder::AssetFolder(const std::filesystem::path& asset, std::vector<SourceFile>* log) : log_(log) {
  std::error_code error;
  folder_ = std::filesystem::canonical(std::filesystem::absolute(asset, error).parent_path(), error);
}

AssetFolder AssetFolder::none() {
  AssetFolder folder;
  folder.has_files_ = false;
  return folder;
}

Result<std::filesystem::path> AssetFolder::resolve(std::string_view uri) const {
  if (!has_files_) return Error{"the URI " + quote(uri) + " names a file, which an embedded asset cannot"};
  if (folder_.empty()) return Error{"the asset's folder does not exist"};
  if (uri.empty()) return Error{"the URI is empty"};
  const std::string name = "the URI " + quote(uri);
  if (has_scheme(uri)) return Error{name + " has a scheme: only data: and relative paths are read"};
  const std::optional<std::string> decoded = percent_decoded(uri);
  if (!decoded) return Error{name + " has a broken percent escape"};
  if (decoded->find('\0') != std::string::npos) return Error{name + " holds a zero byte"};
  // Decoding may reveal a scheme or a backslash; no honest exporter writes them.
  if (has_scheme(*decoded) || decoded->find('\\') != std::string::npos) {
    return Error{name + " is not a relative path with '/' between its parts"};
  }
  const std::filesystem::path relative(*decoded);
  if (relative.is_absolute())
    return Error{name + " is absolute: only paths below the asset's folder are read"};
  if (std::find(relative.begin(), relative.end(), "..") != relative.end()) {
    return Error{name + " leaves the asset's folder"};
  }
  std::error_code error;
  const std::filesystem::path resolved = std::filesystem::canonical(folder_ / relative, error);
  if (error) return Error{"cannot open " + quote(*decoded) + ": " + error.message()};
  const auto [inside, rest] = std::mismatch(folder_.begin(), folder_.end(), resolved.begin(), resolved.end());
  if (inside != folder_.end()) return Error{name + " is a link that leaves the asset's folder"};
  return resolved;
}

Result<FileBytes> AssetFolder::read(std::string_view uri, uint64_t max_bytes) const {
  if (uri.starts_with("data:")) return data_uri_decoded(uri);
  auto path = resolve(uri);
  Result<FileBytes> bytes = path ? read_file(*path, max_bytes) : Result<FileBytes>(path.error());
  if (log_) log_->push_back({std::string(uri), bytes ? digest_of(bytes->view()) : Digest{}});
  return bytes;
}

}  // namespace fire3dv::scene
