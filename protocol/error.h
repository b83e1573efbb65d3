// Errors as values. A function that can fail for a reason outside this program returns Result<T>; the caller
// either handles the error or passes it on, never both. Faults of our own are assertions (FIRE3DV_ASSERT),
// and nothing that arrives from outside may reach one.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace fire3dv {

// One sentence that names the thing at fault (file, field, option, peer) and says what to do about it.
struct [[nodiscard]] Error {
  std::string message;
};

template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }
  T& value() { return std::get<0>(state_); }
  const T& value() const { return std::get<0>(state_); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  const Error& error() const { return std::get<1>(state_); }

 private:
  std::variant<T, Error> state_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}

  bool ok() const { return !error_; }
  explicit operator bool() const { return ok(); }
  const Error& error() const { return *error_; }

 private:
  std::optional<Error> error_;
};

}  // namespace fire3dv

// Aborts on a fault of our own, in release builds too: going on would draw or send something wrong.
#define FIRE3DV_ASSERT(condition)                                                                     \
  do {                                                                                                \
    if (!(condition)) {                                                                               \
      std::fprintf(stderr, "fire3dv: internal error at %s:%d: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                                   \
    }                                                                                                 \
  } while (false)
