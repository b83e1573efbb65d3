// Where a recording's bytes lie: a file, or memory. The format above never seeks while it writes, and reads
// at offsets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "protocol/error.h"
#include "protocol/wire/encode.h"

namespace fire3dv::record {

class Source {
 public:
  virtual ~Source() = default;
  virtual uint64_t size() const = 0;  // when it was opened
  // All of `to`, or an error.
  virtual Result<void> read(uint64_t offset, std::span<std::byte> to) = 0;
  virtual const std::string& name() const = 0;  // for people
};

class Sink {
 public:
  virtual ~Sink() = default;
  virtual Result<void> append(std::span<const std::byte> bytes) = 0;
  // Forgets what was appended behind this length, after an append that failed.
  virtual Result<void> truncate(uint64_t length) = 0;
  // Flushes to the disk: all that was appended survives a power cut. May take as long as the disk takes.
  virtual Result<void> flush() { return {}; }
  // flush() of the complete file. Nothing is appended afterwards.
  virtual Result<void> finish() { return flush(); }
  virtual const std::string& name() const = 0;
};

// Regular files only: a pipe or a device has no size to check lengths against.
Result<std::unique_ptr<Source>> open_source(const std::string& path);
// Makes the file; one that is there already is not touched.
Result<std::unique_ptr<Sink>> create_sink(const std::string& path);
// The same, but the file appears under its name when finish() succeeds. Otherwise nothing is left of it.
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
