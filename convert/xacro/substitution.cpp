#include "convert/xacro/substitution.h"

#include <fnmatch.h>

#include <algorithm>
#include <cstdint>
#include <system_error>
#include <utility>

#include "base/words.h"
#include "convert/description_files.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert::xacro {
namespace {

namespace fs = std::filesystem;
constexpr uint64_t kMaxYamlBytes = uint64_t{8} << 20;
constexpr size_t kMaxWarnings = 50, kMaxParsed = 20'000;

std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  for (std::string_view word = next_word(text); !word.empty(); word = next_word(text))
    words.emplace_back(word);
  return words;
}

}  // namespace

Substitution::Substitution(const fs::path& file, std::map<std::string, std::string> arguments,
                           UrdfFiles& files, Sources& sources, Budget& budget)
    : open_files_{file},
      given_arguments_(std::move(arguments)),
      files_(files),
      sources_(sources),
      budget_(budget) {}

Value Substitution::evaluate_text(const std::string& text, Scope& scope) {
  if (text.find('$') == std::string::npos) {
    budget_.bytes(text.size());
    return text;
  }
  std::string joined;
  Value single;
  size_t parts = 0;
  const auto add = [&](Value part) {
    if (++parts == 1) {
      single = std::move(part);
      return;
    }
    if (parts == 2) joined = text_of(single, budget_);
    joined += text_of(part, budget_);
  };
  for (size_t at = 0; at < text.size();) {
    const std::string_view rest = std::string_view(text).substr(at);
    const size_t dollars = std::min(rest.find_first_not_of('$'), rest.size());
    const bool opens = dollars > 0 && dollars < rest.size() && (rest[dollars] == '{' || rest[dollars] == '(');
    if (opens && dollars > 1) {  // $${ stands for ${
      add(std::string(rest.substr(1, dollars)));
      at += dollars + 1;
    } else if (opens) {
      const size_t end = rest.find(rest[1] == '{' ? '}' : ')');
      if (end == std::string_view::npos)
        throw Failure("'" + std::string(rest.substr(0, 40)) + "' has no closing " +
                      (rest[1] == '{' ? "}" : ")"));
      const std::string inside(rest.substr(2, end - 2));
      add(rest[1] == '{' ? evaluate_expression(inside, scope) : Value(evaluate_command(inside, scope)));
      at += end + 1;
    } else {
      const size_t end = std::min(rest.find('$', std::max<size_t>(dollars, 1)), rest.size());
      budget_.bytes(end);
      add(std::string(rest.substr(0, end)));
      at += end;
    }
  }
  return parts == 1 ? single : Value(std::move(joined));
}

std::string Substitution::evaluate_to_text(const std::string& text, Scope& scope) {
  return text_of(evaluate_text(text, scope), budget_);
}

bool Substitution::boolean(const Value& value, const std::string& condition) {
  const std::string* text = value.as<std::string>();
  if (!text) return is_true(value);
  if (*text == "true" || *text == "True") return true;
  if (*text == "false" || *text == "False") return false;
  int64_t whole = 0;
  if (parse_integer(*text, whole)) return whole != 0;
  throw Failure("the condition \"" + condition + "\" is \"" + *text + "\", which is neither true nor false");
}

Value Substitution::evaluate_expression(const std::string& text, Scope& scope) {
  const Budget::Level level(budget_);
  const std::string inner = evaluate_to_text(text, scope);
  try {
    auto known = parsed_.find(inner);
    if (known == parsed_.end()) {
      if (parsed_.size() >= kMaxParsed) parsed_.clear();
      known = parsed_.emplace(inner, parse_expression(inner)).first;
    }
    // Evaluation may parse further expressions and clear the map, so the expression is taken out of it.
    std::unique_ptr<Expression> expression = std::move(known->second);
    parsed_.erase(known);
    Scope* const outer = std::exchange(scope_, &scope);
    struct Restore {
      Scope*& scope_slot;
      Scope* value;
      ~Restore() { scope_slot = value; }
    } restore{scope_, outer};
    Value value = evaluate(*expression, *this, budget_);
    parsed_[inner] = std::move(expression);
    return value;
  } catch (Failure& failure) {
    failure.add_expression("${" + text.substr(0, 200) + "}");
    throw;
  }
}

std::string Substitution::evaluate_command(const std::string& text, Scope& scope) {
  const Budget::Level level(budget_);
  const std::string evaluated = evaluate_to_text(text, scope);
  if (evaluated.starts_with("eval ")) return evaluate_arguments(evaluated.substr(5));
  const std::vector<std::string> words = words_of(evaluated);
  const std::string command = words.empty() ? "" : words[0];
  if (command == "cwd" && words.size() == 1) return fs::current_path().string();
  if (command == "dirname" && words.size() == 1) return fs::absolute(current_file()).parent_path().string();
  if (command == "arg" && words.size() == 2) return argument(words[1]);
  if (command == "find" && words.size() == 2) return package_folder(words[1]);
  if ((command == "env" && words.size() == 2) || (command == "optenv" && words.size() >= 2)) {
    const auto given = given_arguments_.find(words[1]);
    used_arguments_.insert(words[1]);
    if (given != given_arguments_.end()) return given->second;
    if (command == "env")
      throw Failure("$(env " + words[1] +
                    "): environment variables are not read; give its value with --xacro-arg " + words[1] +
                    "=VALUE");
    std::string otherwise;
    for (size_t i = 2; i < words.size(); ++i) otherwise += (i > 2 ? " " : "") + words[i];
    return otherwise;
  }
  if (command == "anon") refuse_python("$(anon ...)");
  throw Failure("$(" + text.substr(0, 60) +
                ") is none of $(arg NAME), $(find PACKAGE), $(env NAME), $(optenv NAME "
                "DEFAULT), $(dirname) and $(cwd)");
}

// $(eval EXPRESSION): names are arguments of the file, with the types of their texts.
std::string Substitution::evaluate_arguments(const std::string& text) {
  class Arguments : public Environment {
   public:
    explicit Arguments(Substitution& owner) : owner_(owner) {}
    std::optional<Value> property(Scope*, const std::string& name) override {
      if (owner_.has_argument(name)) return literal(owner_.argument(name));
      if (name == "true" || name == "false") return Value(name == "true");
      return std::nullopt;
    }
    std::string argument(const std::string& name) override { return owner_.argument(name); }
    Value load_yaml(const std::string& path) override { return owner_.load_yaml(path); }
    std::string absolute_path(const std::string& path) override { return owner_.absolute_path(path); }
    void message(const std::string& level, const std::string& words) override {
      owner_.message(level, words);
    }

   private:
    Substitution& owner_;
  } arguments(*this);
  try {
    return text_of(evaluate(*parse_expression(text), arguments, budget_), budget_);
  } catch (Failure& failure) {
    failure.add_expression("$(eval " + text.substr(0, 200) + ")");
    throw;
  }
}

bool Substitution::has_argument(const std::string& name) const {
  return given_arguments_.contains(name) || default_arguments_.contains(name);
}

// A package that is not found may serve simulation only. Its $(find) stays, and UrdfFiles resolves it later.
std::string Substitution::package_folder(const std::string& name) {
  const Result<fs::path> folder = files_.package(name, sources_);
  if (folder) return folder->string();
  if (missing_packages_.emplace(name, folder.error().message).second)
    warn("$(find " + name + "): " + folder.error().message);
  return "$(find " + name + ")";
}

void Substitution::set_default_argument(const std::string& name, const std::string& value) {
  default_arguments_.emplace(name, value);
}

std::string Substitution::argument(const std::string& name) {
  used_arguments_.insert(name);
  if (const auto given = given_arguments_.find(name); given != given_arguments_.end()) return given->second;
  if (const auto known = default_arguments_.find(name); known != default_arguments_.end())
    return known->second;
  throw Failure("the argument " + name + " has no value: give one with --xacro-arg " + name + "=VALUE");
}

void Substitution::push_file(const fs::path& file) {
  if (open_files_.size() >= Budget::kMaxIncludeDepth)
    throw Failure("files include each other more than " + std::to_string(Budget::kMaxIncludeDepth) + " deep");
  open_files_.push_back(file);
}

std::string Substitution::absolute_path(const std::string& path) {
  if (path.starts_with("$(find ")) return path;
  return (current_file().parent_path() / path).string();
}

fs::path Substitution::readable_file(const std::string& name) {
  if (++files_read_ > Budget::kMaxFiles)
    throw Failure("more than " + std::to_string(Budget::kMaxFiles) + " files are read");
  if (name.find('\0') != std::string::npos) throw Failure(quote(name) + " holds a zero byte");
  fs::path path = absolute_path(name);
  if (name.starts_with("$(find ")) {
    const Result<fs::path> resolved = files_.resolve(name, sources_);
    if (!resolved) throw Failure(resolved.error().message, Failure::Kind::missing_file);
    for (const std::string& note : files_.take_notes()) warn(note);
    path = *resolved;
  }
  sources_.add(path);
  std::error_code error;
  if (!fs::exists(path, error))
    throw Failure("there is no file " + quote(path.string()), Failure::Kind::missing_file);
  const Result<fs::path> file = regular_file(path);
  if (!file) throw Failure(file.error().message);
  if (!files_.image_folders().hold(*file))
    throw Failure(
        quote(path.string()) +
        " lies outside the folders of the description, of its packages (by their package.xml) and of "
        "--package-path: name its folder with --package-path");
  return path;
}

std::vector<std::string> Substitution::expand_pattern(const std::string& pattern) {
  const fs::path path = absolute_path(pattern);
  if (pattern.find_first_of("*?[") == std::string::npos || pattern.starts_with("$(find ")) return {pattern};
  std::vector<std::string> names;
  std::error_code error;
  sources_.add(path.parent_path());
  for (fs::directory_iterator entry(path.parent_path(), error), end; !error && entry != end;
       entry.increment(error)) {
    budget_.step();
    const std::string name = entry->path().filename().string();
    if (!name.starts_with('.') && ::fnmatch(path.filename().c_str(), name.c_str(), 0) == 0)
      names.push_back(entry->path().string());
  }
  std::sort(names.begin(), names.end());
  if (names.empty()) warn("xacro:include: no file matches " + quote(path.string()));
  return names;
}

void Substitution::warn(const std::string& text) {
  if (warnings_.size() < kMaxWarnings &&
      std::find(warnings_.begin(), warnings_.end(), text) == warnings_.end())
    warnings_.push_back(text);
}

std::vector<std::string> Substitution::take_warnings() {
  for (const auto& [name, value] : given_arguments_)
    if (!used_arguments_.contains(name) && !default_arguments_.contains(name))
      warn("--xacro-arg " + name + ": the file has no such argument");
  return std::exchange(warnings_, {});
}

std::optional<Value> Substitution::property(Scope* scope, const std::string& name) {
  Scope* const owner = (scope ? scope : scope_)->owner_of(name);
  if (!owner) return std::nullopt;
  Property& property = owner->properties.at(name);
  if (const std::string* text = property.value.as<std::string>()) budget_.bytes(text->size());
  if (!property.is_lazy) return property.value;
  if (property.is_being_evaluated) throw Failure("the property " + name + " depends on itself");
  property.is_being_evaluated = true;
  struct Done {
    Property& property;
    ~Done() { property.is_being_evaluated = false; }
  } done{property};
  Value value = evaluate_text(*property.value.as<std::string>(), *owner);
  property.value = value.as<std::string>() ? literal(*value.as<std::string>()) : std::move(value);
  property.is_lazy = false;
  return property.value;
}

Value Substitution::load_yaml(const std::string& path) {
  const fs::path file = readable_file(path);
  const Result<FileBytes> bytes = read_file(file, kMaxYamlBytes);
  if (!bytes) throw Failure(bytes.error().message);
  return value_of_yaml(std::string(reinterpret_cast<const char*>(bytes->data.get()), bytes->size),
                       file.string(), *this, budget_);
}

void Substitution::message(const std::string& level, const std::string& text) {
  if (level != "message" && !text.empty()) warn("xacro." + level + "(): " + text);
}

}  // namespace fire3dv::convert::xacro
