#include "renderer/app/options/config_options.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <utility>

namespace fire3dv::app {
namespace {

using Lines = std::vector<ConfigLine>;

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// The lines follow the words, so that an option with an optional value does not take the scene for it.
std::vector<std::string> joined(const std::vector<std::string>& words, const Lines& lines) {
  std::vector<std::string> all = words;
  auto at = std::find(all.begin(), all.end(), "--");
  for (const ConfigLine& line : lines) at = std::next(all.insert(at, line.argument()));
  return all;
}

// Each line in itself, and with the earlier ones of its name: most options may be set once.
std::optional<UsageError> check_lines(const ParseWords& parse, const Lines& lines, const std::string& file) {
  for (size_t i = 0; i < lines.size(); ++i) {
    const ConfigLine& line = lines[i];
    const std::string position = file + ":" + std::to_string(line.number) + ": ";
    for (const char* name : {"config", "drake", "help", "version", "h"}) {
      if (line.name == name)
        return UsageError{kUsageExitCode, position + "--" + name + " is an option of command lines only"};
    }
    const auto alone = parse({line.argument()}, OptionChecks::words, nullptr);
    if (const auto* error = std::get_if<UsageError>(&alone))
      return UsageError{kUsageExitCode, position + error->text};
    std::vector<std::string> same;
    const ConfigLine* first = nullptr;
    for (size_t k = 0; k <= i; ++k) {
      if (lines[k].name != line.name) continue;
      if (!first) first = &lines[k];
      same.push_back(lines[k].argument());
    }
    if (same.size() == 1) continue;
    if (std::holds_alternative<UsageError>(parse(same, OptionChecks::words, nullptr)))
      return UsageError{kUsageExitCode, position + "--" + line.name + " is set in line " +
                                            std::to_string(first->number) + " already; remove one"};
  }
  return std::nullopt;
}

using Parsed = std::variant<Options, UsageError>;

bool is_error(const Parsed& parsed) {
  return std::holds_alternative<UsageError>(parsed);
}

// The words and those of the lines that they agree with. Lines may need one another, and words a line.
class Agreement {
 public:
  Agreement(const ParseWords& parse, const std::vector<std::string>& words, Lines lines)
      : parse_(parse),
        words_(words),
        pending_(std::move(lines)),
        parsed_(parse(words, OptionChecks::all, nullptr)) {}

  Parsed find() {
    while (is_error(parsed_) && (add_lines(true) || add_lines(false))) {
    }
    while (!is_error(parsed_) && add_lines(true)) {
    }
    return std::move(parsed_);
  }
  const Lines& left_out() const { return pending_; }
  // The reason of each of those.
  std::string reason(const ConfigLine& line) const {
    Lines with_line = kept_;
    with_line.push_back(line);
    const Parsed parsed = parse_(joined(words_, with_line), OptionChecks::all, nullptr);
    return is_error(parsed) ? std::get<UsageError>(parsed).text : "";
  }

 private:
  // Adds lines that lead to no error. While there is an error, adds one line that ends it, or with
  // without_error false, changes it.
  bool add_lines(bool without_error) {
    bool is_found = false;
    for (auto line = pending_.begin(); line != pending_.end();) {
      kept_.push_back(*line);
      Parsed with_line = parse_(joined(words_, kept_), OptionChecks::all, nullptr);
      const bool agrees = without_error
                              ? !is_error(with_line)
                              : std::get<UsageError>(with_line).text != std::get<UsageError>(parsed_).text;
      if (!agrees) {
        kept_.pop_back();
        ++line;
        continue;
      }
      is_found = true;
      line = pending_.erase(line);
      const bool was_error = is_error(std::exchange(parsed_, std::move(with_line)));
      if (was_error) break;
    }
    return is_found;
  }

  const ParseWords& parse_;
  const std::vector<std::string>& words_;
  Lines pending_, kept_;
  Parsed parsed_;
};

}  // namespace

std::variant<Options, UsageError> parse_with_config(
    const ParseWords& parse, const std::vector<std::string>& words,
    const std::function<const char*(const char*)>& environment, std::vector<std::string>& notes) {
  GivenOptions given;
  auto command_line = parse(words, OptionChecks::words, &given);
  if (std::holds_alternative<UsageError>(command_line)) return command_line;
  const ConfigPath path = config_path(given.config, environment);
  const char* const home = environment("HOME");
  Result<Lines> lines = read_config(path, home ? home : "");
  if (!lines) return UsageError{kUsageExitCode, lines.error().message + "; --config none reads no file"};
  if (auto wrong = check_lines(parse, *lines, path.file.string())) return std::move(*wrong);
  std::erase_if(*lines, [&](const ConfigLine& line) {
    return contains(given.present, line.name) || contains(given.excluded, line.name);
  });
  auto parsed = parse(joined(words, *lines), OptionChecks::all, nullptr);
  if (std::holds_alternative<Options>(parsed) || lines->empty()) return parsed;
  Agreement agreement(parse, words, std::move(*lines));
  Parsed agreed = agreement.find();
  if (is_error(agreed)) return agreed;
  for (const ConfigLine& line : agreement.left_out()) {
    notes.push_back(path.file.string() + ":" + std::to_string(line.number) + ": --" + line.name +
                    " is left out: " + agreement.reason(line));
  }
  return agreed;
}

}  // namespace fire3dv::app
