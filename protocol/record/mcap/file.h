// Byte sources and sinks of recordings: files or memory. Writers only append; readers read at offsets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/error.h"
#include "protocol/wire/encode.h"

namespace fire3dv::record {

class Source {
 public:
  virtual ~Source() = default;
  virtual uint64_t size() const = 0;  // size when the source was opened
  // Fills all of `to` or returns an error.
  virtual Result<void> read(uint64_t offset, std::span<std::byte> to) = 0;
  virtual const std::string& name() const = 0;  // for messages
};

class Sink {
 public:
  virtual ~Sink() = default;
  virtual Result<void> append(std::span<const std::byte> bytes) = 0;
  // Discards the bytes beyond this length after a failed append.
  virtual Result<void> truncate(uint64_t length) = 0;
  // Flushes to the disk: all appended bytes survive a power cut. Blocks for as long as the disk takes.
  virtual Result<void> flush() { return {}; }
  // Flushes the complete file. append() is invalid afterwards.
  virtual Result<void> finish() { return flush(); }
  // Fails if the file lost its name meanwhile: it was removed, moved or replaced. finish() checks it, too.
  virtual Result<void> check_name() const { return {}; }
  virtual const std::string& name() const = 0;
};

// Opens regular files only: a pipe or device has no size to validate lengths against.
Result<std::unique_ptr<Source>> open_source(const std::string& path);
// Creates the file; fails if it exists.
Result<std::unique_ptr<Sink>> create_sink(const std::string& path);
// Same as create_sink(), but the file appears under its name only when finish() succeeds. Otherwise it is
// removed.
Result<std::unique_ptr<Sink>> create_atomic_sink(const std::string& path);

class MemorySource final : public Source {
 public:
  explicit MemorySource(wire::Bytes bytes, std::string name = "memory")
      : bytes_(std::move(bytes)), name_(std::move(name)) {}
  uint64_t size() const override { return bytes_.size(); }
  Result<void> read(uint64_t offset, std::span<std::byte> to) override;
  const std::string& name() const override { return name_; }

 private:
  wire::Bytes bytes_;
  std::string name_;
};

class MemorySink final : public Sink {
 public:
  explicit MemorySink(wire::Bytes& bytes) : bytes_(bytes) {}
  Result<void> append(std::span<const std::byte> bytes) override;
  Result<void> truncate(uint64_t length) override;
  const std::string& name() const override { return name_; }

 private:
  wire::Bytes& bytes_;
  std::string name_ = "memory";
};

}  // namespace fire3dv::record
