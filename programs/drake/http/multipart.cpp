#include "programs/drake/http/multipart.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "base/text.h"
#include "base/words.h"

namespace fire3dv::drake {
namespace {

constexpr size_t kMaxBoundary = 70;  // RFC 2046
constexpr std::string_view kSpaces = " \t";

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, [](char x, char y) { return lower(x) == lower(y); });
}

// Takes the next "name=value" of a header's parameters; the value may be a quoted string.
struct Parameter {
  std::string_view name;
  std::string value;
};
std::optional<Parameter> take_parameter(std::string_view& rest) {
  const size_t begin = rest.find_first_not_of("; \t");
  if (begin == std::string_view::npos) return std::nullopt;
  rest.remove_prefix(begin);
  const size_t end = std::min(rest.find_first_of("=;"), rest.size());
  Parameter parameter{trimmed(rest.substr(0, end), kSpaces), {}};
  rest.remove_prefix(end);
  if (!rest.starts_with('=')) return parameter;
  rest.remove_prefix(1);
  rest.remove_prefix(std::min(rest.find_first_not_of(kSpaces), rest.size()));
  if (!rest.starts_with('"')) {
    const size_t value_end = std::min(rest.find(';'), rest.size());
    parameter.value = trimmed(rest.substr(0, value_end), kSpaces);
    rest.remove_prefix(value_end);
    return parameter;
  }
  size_t at = 1;
  for (; at < rest.size() && rest[at] != '"'; ++at) {
    if (rest[at] == '\\' && at + 1 < rest.size()) ++at;
    parameter.value += rest[at];
  }
  rest.remove_prefix(std::min(at + 1, rest.size()));
  return parameter;
}

// Splits "token; parameters".
std::string_view take_token(std::string_view& header) {
  const size_t end = std::min(header.find(';'), header.size());
  const std::string_view token = trimmed(header.substr(0, end), kSpaces);
  header.remove_prefix(end);
  return token;
}

Result<std::string> boundary_of(std::string_view content_type) {
  if (!equal_ignoring_case(take_token(content_type), "multipart/form-data"))
    return Error{"the Content-Type must be multipart/form-data"};
  while (auto parameter = take_parameter(content_type)) {
    if (!equal_ignoring_case(parameter->name, "boundary")) continue;
    if (parameter->value.empty() || parameter->value.size() > kMaxBoundary) break;
    return std::move(parameter->value);
  }
  return Error{"the Content-Type names no boundary of 1 to 70 characters"};
}

// Reads the headers of one part, up to and without the empty line.
Result<FormPart> read_headers(std::string_view headers, const std::string& part_name) {
  FormPart part;
  bool has_disposition = false;
  while (!headers.empty()) {
    const size_t end = std::min(headers.find("\r\n"), headers.size());
    std::string_view line = headers.substr(0, end);
    headers.remove_prefix(std::min(end + 2, headers.size()));
    const size_t colon = line.find(':');
    if (colon == std::string_view::npos) return Error{part_name + " has a header line without a colon"};
    if (!equal_ignoring_case(trimmed(line.substr(0, colon), kSpaces), "content-disposition")) continue;
    line.remove_prefix(colon + 1);
    if (!equal_ignoring_case(take_token(line), "form-data"))
      return Error{part_name + ": the Content-Disposition must be form-data"};
    while (auto parameter = take_parameter(line)) {
      if (equal_ignoring_case(parameter->name, "name")) {
        part.name = std::move(parameter->value);
        has_disposition = true;
      }
      part.is_file |= equal_ignoring_case(parameter->name, "filename");
    }
  }
  if (!has_disposition || part.name.empty())
    return Error{part_name + " has no Content-Disposition with a name"};
  return part;
}

}  // namespace

Result<std::vector<FormPart>> parse_multipart(std::string_view body, std::string_view content_type,
                                              const MultipartLimits& limits) {
  const Result<std::string> boundary = boundary_of(content_type);
  if (!boundary) return boundary.error();
  const std::string delimiter = "\r\n--" + *boundary;
  // The first delimiter may begin the body, without its line break.
  size_t at = delimiter.size() - 2;
  if (!body.starts_with(std::string_view(delimiter).substr(2))) {
    const size_t first = body.find(delimiter);
    if (first == std::string_view::npos)
      return Error{"the body does not hold the boundary that its Content-Type names"};
    at = first + delimiter.size();
  }
  std::vector<FormPart> parts;
  for (;;) {  // `at` is behind a delimiter
    if (body.substr(at).starts_with("--")) return parts;
    const std::string part_name = "part " + std::to_string(parts.size() + 1) + " of the form";
    if (parts.size() == limits.max_parts)
      return Error{"the form has more than " + std::to_string(limits.max_parts) + " parts"};
    at = std::min(body.find_first_not_of(kSpaces, at), body.size());
    if (!body.substr(at).starts_with("\r\n"))
      return Error{part_name + ": a line break must follow the boundary"};
    // An empty header block is a single line break, which this line break already is half of.
    const size_t headers_end =
        body.substr(0, std::min(body.size(), at + limits.max_header_bytes)).find("\r\n\r\n", at);
    if (headers_end == std::string_view::npos)
      return Error{part_name + " is cut short, or its headers exceed " +
                   std::to_string(limits.max_header_bytes) + " bytes"};
    const size_t headers_begin = std::min(at + 2, headers_end);
    Result<FormPart> part = read_headers(body.substr(headers_begin, headers_end - headers_begin), part_name);
    if (!part) return part.error();
    const size_t data_begin = headers_end + 4;
    // The line break of the headers may also be that of the delimiter: the part is empty then.
    const size_t data_end = body.find(delimiter, data_begin - 2);
    if (data_end == std::string_view::npos)
      return Error{part_name + " (" + printable_text(part->name, 80) + ") is cut short: no boundary follows"};
    part->data = body.substr(data_begin, std::max(data_end, data_begin) - data_begin);
    parts.push_back(std::move(*part));
    at = data_end + delimiter.size();
  }
}

}  // namespace fire3dv::drake
