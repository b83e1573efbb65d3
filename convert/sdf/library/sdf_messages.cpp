#include "convert/sdf/library/sdf_messages.h"

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <iterator>
#include <optional>
#include <regex>
#include <sdf/Error.hh>
#include <string_view>

#include "base/text.h"

namespace fire3dv::convert {
namespace {

constexpr size_t kMaxMessages = 100;

// Opens the console without its log file, ~/.sdformat/sdformat.log.
sdf::ConsolePtr console() {
  static const sdf::ConsolePtr opened = [] {
    const char* value = std::getenv("HOME");
    const std::optional<std::string> home = value ? std::optional<std::string>(value) : std::nullopt;
    ::setenv("HOME", "/dev/null", 1);
    const sdf::ConsolePtr made = sdf::Console::Instance();
    if (home)
      ::setenv("HOME", home->c_str(), 1);
    else
      ::unsetenv("HOME");
    return made;
  }();
  return opened;
}

std::string without_colours(const std::string& text) {
  std::string plain;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\x1b' && i + 1 < text.size() && text[i + 1] == '[') {
      i = std::min(text.find('m', i), text.size() - 1);
    } else {
      plain += text[i];
    }
  }
  return plain;
}

// Elements of newer versions that are read all the same, and parents that only physics reads.
bool concerns_drawing(const std::string& element, const std::string& parent) {
  if (element == "cone" || element == "mimic") return false;
  constexpr std::string_view kPhysics[] = {
      "inertial",  "collision", "surface", "contact", "friction", "bounce", "ode",         "bullet", "dart",
      "torsional", "physics",   "solver",  "simbody", "dynamics", "limit",  "constraints", "gripper"};
  return std::find(std::begin(kPhysics), std::end(kPhysics), parent) == std::end(kPhysics);
}

// Shortens what libsdformat says of an element or attribute that SDF does not have. Empty: not worth a
// warning.
std::string shortened(const std::string& message) {
  static const std::regex unknown_element(
      R"(XML Element\[([^\]]*)\], child of element\[([^\]]*)\], not defined in SDF.*)");
  static const std::regex unknown_attribute(
      R"(XML Attribute\[([^\]]*)\] in element\[([^\]]*)\] not defined in SDF.*)");
  std::smatch match;
  if (std::regex_search(message, match, unknown_element)) {
    const std::string element = match[1].str(), parent = match[2].str();
    if (!concerns_drawing(element, parent)) return {};
    return match.prefix().str() + "<" + element + "> in <" + parent + "> is unknown and ignored";
  }
  if (std::regex_search(message, match, unknown_attribute)) {
    const std::string parent = match[2].str();
    if (!concerns_drawing("", parent)) return {};
    return match.prefix().str() + "the attribute " + match[1].str() + " of <" + parent +
           "> is unknown and ignored";
  }
  return message;
}

}  // namespace

SdfMessages::SdfMessages(const SdfDocuments& documents)
    : documents_(documents),
      console_(console()->GetMsgStream().GetStream()),
      error_buffer_(std::cerr.rdbuf(text_.rdbuf())),
      output_buffer_(std::cout.rdbuf(text_.rdbuf())) {
  console()->GetMsgStream().SetStream(&text_);
}

SdfMessages::~SdfMessages() {
  console()->GetMsgStream().SetStream(console_);
  std::cerr.rdbuf(error_buffer_);
  std::cout.rdbuf(output_buffer_);
}

void SdfMessages::add(const sdf::Error& error) {
  std::string location = error.FilePath().value_or("");
  if (location.starts_with('<')) location.clear();
  if (error.LineNumber()) location += ", line " + std::to_string(*error.LineNumber());
  if (error.XmlPath()) location += (location.empty() ? "" : ", ") + *error.XmlPath();
  add((location.empty() ? "" : location + ": ") + error.Message());
}

void SdfMessages::add(std::string message) {
  message = documents_.with_originals(shortened(message));
  while (!message.empty() && (message.back() == '\n' || message.back() == ' ')) message.pop_back();
  constexpr size_t kMaxBytes = 500;
  message = printable_text(message, kMaxBytes);
  const bool only_repeats = message == "Failed to load a world." || message == "Failed to load a model.";
  if (message.empty() || only_repeats ||
      std::find(messages_.begin(), messages_.end(), message) != messages_.end())
    return;
  if (messages_.size() < kMaxMessages)
    messages_.push_back(std::move(message));
  else
    ++left_out_;
}

std::vector<std::string> SdfMessages::take() {
  // "Warning [parser.cc:12] TEXT", "Error Code 19: [/sdf/...:FILE:L12]: Msg: TEXT", "[/sdf/...:FILE:L12]:
  // TEXT"
  static const std::regex prefix(R"(^(Warning|Error|Msg|Dbg) \[[^\]]*\] *)");
  static const std::regex located(
      R"(^(?:(?:Error|Warning):? *)?(?:Error Code \d+:? *)?\[(?:.*:)?(/[^:]*):L(\d+)\]: *(?:Msg: *)?)");
  static const std::regex code(R"(^(?:(?:Error|Warning):? *)?Error Code \d+:? *(?:Msg: *)?)");
  std::istringstream lines(without_colours(text_.str()));
  text_.str("");
  for (std::string line; std::getline(lines, line);) {
    line = std::regex_replace(line, prefix, "");
    std::smatch match;
    if (std::regex_search(line, match, located))
      line = match[1].str() + ", line " + match[2].str() + ": " + match.suffix().str();
    else
      line = std::regex_replace(line, code, "");
    add(std::move(line));
  }
  if (left_out_ > 0)
    messages_.push_back("libsdformat has " + std::to_string(left_out_) + " further messages");
  left_out_ = 0;
  return std::exchange(messages_, {});
}

}  // namespace fire3dv::convert
