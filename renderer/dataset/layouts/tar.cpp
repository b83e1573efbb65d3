#include "renderer/dataset/layouts/tar.h"

#include <array>
#include <cstdio>
#include <cstring>
#include <utility>
#include <vector>

namespace fire3dv::dataset {
namespace {

constexpr size_t kBlock = 512;
constexpr size_t kRecord = 20 * kBlock;  // archives end at a multiple of it

// Header block, IEEE 1003.1, "ustar Interchange Format".
std::array<char, kBlock> make_header(const std::string& name, uint64_t bytes) {
  std::array<char, kBlock> header{};
  const auto put = [&](size_t at, const std::string& text) {
    std::memcpy(header.data() + at, text.data(), text.size());
  };
  const auto octal = [](uint64_t value, int digits) {
    char text[32];
    std::snprintf(text, sizeof text, "%0*llo", digits, static_cast<unsigned long long>(value));
    return std::string(text);
  };
  put(0, name);
  put(100, "0000644");  // mode
  put(108, "0000000");  // owner
  put(116, "0000000");  // group
  put(124, octal(bytes, 11));
  put(136, "00000000000");  // time
  put(148, "        ");     // checksum, of blanks in its own place
  put(156, "0");            // regular file
  put(257, std::string("ustar\0"
                       "00",
                       8));
  uint64_t sum = 0;
  for (const char c : header) sum += static_cast<unsigned char>(c);
  put(148, octal(sum, 6) + std::string("\0 ", 2));
  return header;
}

std::span<const std::byte> as_bytes(std::span<const char> text) {
  return std::as_bytes(text);
}

}  // namespace

Result<TarFile> TarFile::create(const std::filesystem::path& path) {
  auto file = base::AtomicFile::create(path);
  if (!file) return file.error();
  return TarFile(std::move(*file));
}

Result<void> TarFile::add(const std::string& name, std::span<const uint8_t> bytes) {
  constexpr size_t kMaxName = 99;
  constexpr uint64_t kMaxBytes = uint64_t{1} << 33;  // 11 octal digits
  FIRE3DV_ASSERT(name.size() <= kMaxName && bytes.size() < kMaxBytes);
  const std::array<char, kBlock> header = make_header(name, bytes.size());
  if (auto added = file_.append(as_bytes(header)); !added) return added;
  if (auto added = file_.append(std::as_bytes(bytes)); !added) return added;
  const std::vector<char> padding((kBlock - bytes.size() % kBlock) % kBlock);
  if (auto added = file_.append(as_bytes(padding)); !added) return added;
  bytes_ += tar_bytes(bytes.size());
  return {};
}

Result<uint64_t> TarFile::finish() {
  uint64_t end = bytes_ + 2 * kBlock;
  end = (end + kRecord - 1) / kRecord * kRecord;
  const std::vector<char> zeros(end - bytes_);
  if (auto added = file_.append(as_bytes(zeros)); !added) return added.error();
  if (auto done = file_.commit(); !done) return done.error();
  return end;
}

}  // namespace fire3dv::dataset
