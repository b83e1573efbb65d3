// Limits of one xacro expansion: steps, produced bytes and nesting. A short file can request unbounded work
// (recursive macros, repeated doubling of a string), so every operation is charged here.
#pragma once

#include <cstddef>
#include <exception>
#include <string>
#include <utility>

namespace fire3dv::convert::xacro {

// Error inside the expansion. expand_xacro() catches it and returns an Error; it never leaves this folder.
class Failure : public std::exception {
 public:
  enum class Kind {
    error,
    missing_file,  // xacro:include optional="true" ignores it
    unsupported,   // the program xacro may read it
  };
  explicit Failure(std::string message, Kind kind = Kind::error)
      : message_(std::move(message)), kind_(kind) {}

  const char* what() const noexcept override { return message_.c_str(); }
  const std::string& message() const { return message_; }
  Kind kind() const { return kind_; }

  // Puts the innermost expression before the message.
  void add_expression(const std::string& expression) {
    if (!has_expression_ && !located_) message_ = expression + ": " + message_;
    has_expression_ = true;
  }
  // Puts the location of the innermost element before the message.
  void locate(const std::string& location) {
    if (!located_) message_ = location + ": " + message_;
    located_ = true;
  }
  // Adds a macro call around the location.
  void add_call(const std::string& call) {
    constexpr size_t kMaxCalls = 4;
    if (++calls_ <= kMaxCalls) message_ += (calls_ == 1 ? ", in " : ", called by ") + call;
  }

 private:
  std::string message_;
  Kind kind_;
  bool has_expression_ = false, located_ = false;
  size_t calls_ = 0;
};

class Budget {
 public:
  static constexpr size_t kMaxSteps = 10'000'000;
  static constexpr size_t kMaxBytes = size_t{128} << 20;  // of all intermediate texts
  static constexpr size_t kMaxOutputBytes = size_t{64} << 20;
  static constexpr size_t kMaxDepth = 300;  // nested elements, macro calls and properties
  static constexpr size_t kMaxFiles = 1000;
  static constexpr size_t kMaxIncludeDepth = 50;

  void step(size_t count = 1) {
    steps_ += count;
    if (steps_ > kMaxSteps || count > kMaxSteps)
      throw Failure("the expansion takes more than " + std::to_string(kMaxSteps) +
                    " steps; does a macro call itself without end?");
  }
  // Charges text before it is made.
  void bytes(size_t count) {
    bytes_ += count;
    if (bytes_ > kMaxBytes || count > kMaxBytes)
      throw Failure("the expansion makes more than " + std::to_string(kMaxBytes >> 20) + " MiB of text");
  }

  // Nesting level, for the lifetime of the object.
  class Level {
   public:
    explicit Level(Budget& budget) : budget_(budget) {
      if (budget_.depth_ >= kMaxDepth)
        throw Failure("elements, macros and properties are nested more than " + std::to_string(kMaxDepth) +
                      " deep; does a macro call itself without end?");
      ++budget_.depth_;
    }
    ~Level() { --budget_.depth_; }
    Level(const Level&) = delete;
    Level& operator=(const Level&) = delete;

   private:
    Budget& budget_;
  };

 private:
  size_t steps_ = 0, bytes_ = 0, depth_ = 0;
};

}  // namespace fire3dv::convert::xacro
