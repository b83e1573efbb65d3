// Text of an exception that ends a program.
#pragma once

#include <exception>
#include <string>

namespace fire3dv {

// Out of memory: with the limit of the address space, and what was being done (Activity).
std::string describe_failure(const std::exception& failure);

// Names what the process does while it lives. An exception that leaves it is described with the innermost
// name. name: a literal, such as "loading the scene".
class Activity {
 public:
  explicit Activity(const char* name) : name_(name), exceptions_(std::uncaught_exceptions()) {}
  ~Activity();
  Activity(const Activity&) = delete;
  Activity& operator=(const Activity&) = delete;

 private:
  const char* name_;
  int exceptions_;
};

}  // namespace fire3dv
