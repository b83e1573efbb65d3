#include "renderer/dataset/layouts/tar.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <utility>

#include "base/numbers.h"
#include "base/unique_fd.h"

namespace fire3dv::dataset {
namespace {

constexpr size_t kBlock = 512;

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
  const uint64_t end = archive_bytes(bytes_);
  const std::vector<char> zeros(end - bytes_);
  if (auto added = file_.append(as_bytes(zeros)); !added) return added.error();
  if (auto done = file_.commit(); !done) return done.error();
  return end;
}

Result<std::vector<uint8_t>> read_tar_file(const std::filesystem::path& archive, const std::string& name,
                                           uint64_t max_bytes) {
  const UniqueFd file(::open(archive.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat about {};
  if (!file || ::fstat(file.get(), &about) != 0 || !S_ISREG(about.st_mode))
    return Error{"cannot read " + archive.string() + ": no regular file"};
  const auto archive_bytes = static_cast<uint64_t>(about.st_size);
  std::array<char, kBlock> header{};
  for (uint64_t at = 0; at + kBlock <= archive_bytes;) {
    if (::pread(file.get(), header.data(), kBlock, static_cast<off_t>(at)) != ssize_t{kBlock}) break;
    const auto bytes = parse_number<uint64_t>(std::string_view(header.data() + 124, 11), 8);
    if (!bytes || *bytes > archive_bytes - at - kBlock) break;
    if (std::string_view(header.data(), ::strnlen(header.data(), 100)) != name) {
      at += tar_bytes(*bytes);
      continue;
    }
    if (*bytes > max_bytes) break;
    std::vector<uint8_t> contents(*bytes);
    const ssize_t got =
        ::pread(file.get(), contents.data(), contents.size(), static_cast<off_t>(at + kBlock));
    if (got != static_cast<ssize_t>(contents.size())) break;
    return contents;
  }
  return Error{archive.string() + " has no whole file " + name};
}

}  // namespace fire3dv::dataset
