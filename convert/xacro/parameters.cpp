#include <algorithm>
#include <string_view>

#include "convert/xacro/scope.h"

namespace fire3dv::convert::xacro {
namespace {

constexpr std::string_view kParameterSpace = " \t\r\n";

bool is_space_or_end(std::string_view text, size_t at) {
  return at >= text.size() || kParameterSpace.find(text[at]) != std::string_view::npos;
}

// Length of a default value at the start of the text: ${...} or $(...) before white space, or words in which
// quotes protect white space.
size_t length_of_default(std::string_view text) {
  const char closing = text.starts_with("${") ? '}' : text.starts_with("$(") ? ')' : 0;
  if (closing) {
    for (size_t end = text.find(closing); end != std::string_view::npos; end = text.find(closing, end + 1))
      if (is_space_or_end(text, end + 1)) return end + 1;
  }
  size_t at = 0;
  while (!is_space_or_end(text, at)) {
    if (text[at] == '\'' || text[at] == '"') {
      const size_t end = text.find(text[at], at + 1);
      if (end == std::string_view::npos) throw Failure("a quote of params has no end");
      at = end;
    }
    ++at;
  }
  return at;
}

}  // namespace

std::vector<Parameter> parse_parameters(const std::string& text) {
  std::vector<Parameter> parameters;
  std::string_view rest = text;
  const auto skip_space = [&] {
    rest.remove_prefix(std::min(rest.find_first_not_of(kParameterSpace), rest.size()));
  };
  for (skip_space(); !rest.empty(); skip_space()) {
    Parameter parameter;
    const size_t end = std::min(rest.find_first_of(" \t\r\n:="), rest.size());
    if (end == 0) throw Failure("params has no name before '" + std::string(rest.substr(0, 20)) + "'");
    parameter.name = rest.substr(0, end);
    std::string_view after = rest.substr(end);
    after.remove_prefix(std::min(after.find_first_not_of(kParameterSpace), after.size()));
    if (after.starts_with(':')) after.remove_prefix(1);
    if (after.starts_with('=')) {
      parameter.has_default = true;
      rest = after.substr(1);
      skip_space();
      if (rest.starts_with('^')) {
        parameter.is_forwarded = true;
        rest.remove_prefix(rest.starts_with("^|") ? 2 : 1);
      }
      const size_t length = length_of_default(rest);
      if (length > 0) parameter.fallback = rest.substr(0, length);
      rest.remove_prefix(length);
    } else {
      rest.remove_prefix(end);
      if (rest.starts_with(':')) throw Failure("params has ':' without '=' behind " + parameter.name);
    }
    parameters.push_back(std::move(parameter));
  }
  return parameters;
}

}  // namespace fire3dv::convert::xacro
