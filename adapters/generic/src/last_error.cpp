#include "last_error.h"

#include <algorithm>
#include <cstring>

namespace fire3dv::client {
namespace {

thread_local char sentence_of_thread[1024] = "";

}  // namespace

int fail(int code, std::string_view sentence) noexcept {
  const size_t length = std::min(sentence.size(), sizeof sentence_of_thread - 1);
  std::memcpy(sentence_of_thread, sentence.data(), length);
  sentence_of_thread[length] = '\0';
  return code;
}

const char* last_error() noexcept {
  return sentence_of_thread;
}

}  // namespace fire3dv::client
