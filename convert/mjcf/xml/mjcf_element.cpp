#include "convert/mjcf/xml/mjcf_element.h"

#include <strings.h>
#include <tinyxml2.h>

#include <set>

#include "convert/description_files.h"
#include "convert/xml_error.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxElements = 2'000'000, kMaxFiles = 1000;
constexpr uint64_t kMaxBytes = uint64_t{256} << 20;
constexpr int kMaxDepth = 200;

class Loader {
 public:
  Loader(const fs::path& model, MjcfFiles& files) : folder_(model.parent_path()), files_(files) {}

  // Appends the root's children to `to`, whose own tag and attributes come from the root if it is the
  // model's.
  Result<void> load(const fs::path& file, MjcfElement& to, bool is_model, int depth) {
    std::error_code error;
    const fs::path canonical = fs::weakly_canonical(file, error);
    const auto [open, is_new] = open_.insert(error ? file : canonical);
    if (!is_new) return Error{quote(file.string()) + " includes itself: remove one of the include elements"};
    if (++files_read_ > kMaxFiles)
      return Error{"the model includes more than " + std::to_string(kMaxFiles) + " files"};
    Result<void> done = parse(file, to, is_model, depth);
    open_.erase(open);
    return done;
  }

 private:
  Result<void> parse(const fs::path& file, MjcfElement& to, bool is_model, int depth) {
    Result<std::string> text = read_text(file);
    if (!text) return text.error();
    text->resize(without_extra_ends(*text).size());
    bytes_ += text->size();
    if (bytes_ > kMaxBytes) return Error{"the files of the model have more than 256 MiB of text"};
    const Result<std::string> root_name = xml_root(*text);
    if (!root_name) return Error{quote(file.string()) + ": " + root_name.error().message};
    tinyxml2::XMLDocument document;
    if (document.Parse(text->c_str(), text->size()) != tinyxml2::XML_SUCCESS)
      return Error{quote(file.string()) + ", " + xml_error(document)};
    const tinyxml2::XMLElement* const root = document.RootElement();
    if (!root) return Error{quote(file.string()) + " holds no XML element"};
    const auto shared = std::make_shared<const fs::path>(file);
    if (is_model) take_attributes(*root, shared, to);
    return take_children(*root, shared, to, depth);
  }

  static void take_attributes(const tinyxml2::XMLElement& from, const std::shared_ptr<const fs::path>& file,
                              MjcfElement& to) {
    to.kind = from.Value();
    to.file = file;
    to.line = from.GetLineNum();
    for (const tinyxml2::XMLAttribute* a = from.FirstAttribute(); a; a = a->Next())
      to.attributes.emplace_back(a->Name(), a->Value());
  }

  Result<void> take_children(const tinyxml2::XMLElement& from, const std::shared_ptr<const fs::path>& file,
                             MjcfElement& to, int depth) {
    if (depth > kMaxDepth)
      return Error{quote(file->string()) + ": elements are nested more than " + std::to_string(kMaxDepth) +
                   " levels deep"};
    for (const tinyxml2::XMLElement* child = from.FirstChildElement(); child;
         child = child->NextSiblingElement()) {
      if (++elements_ > kMaxElements)
        return Error{"the model has more than " + std::to_string(kMaxElements) + " elements"};
      if (strcasecmp(child->Value(), "include") == 0) {  // MuJoCo ignores the case of this tag alone
        if (Result<void> done = include(*child, file, to, depth); !done) return done;
        continue;
      }
      MjcfElement& made = to.children.emplace_back();
      take_attributes(*child, file, made);
      if (Result<void> done = take_children(*child, file, made, depth + 1); !done) return done;
    }
    return {};
  }

  Result<void> include(const tinyxml2::XMLElement& element, const std::shared_ptr<const fs::path>& file,
                       MjcfElement& to, int depth) {
    const std::string where =
        quote(file->string()) + ", line " + std::to_string(element.GetLineNum()) + ": include: ";
    const char* const name = element.Attribute("file");
    if (!name || !*name) return Error{where + "the attribute file is missing"};
    const Result<fs::path> found = files_.find(name, {folder_, file->parent_path()});
    if (!found) return Error{where + found.error().message};
    return load(*found, to, false, depth + 1);
  }

  const fs::path folder_;
  MjcfFiles& files_;
  std::set<fs::path> open_;  // being read, each included by the one before
  size_t files_read_ = 0, elements_ = 0;
  uint64_t bytes_ = 0;
};

}  // namespace

const std::string* MjcfElement::find(std::string_view attribute) const {
  for (const auto& [name, value] : attributes)
    if (name == attribute) return &value;
  return nullptr;
}

std::string MjcfElement::text(std::string_view attribute) const {
  const std::string* const value = find(attribute);
  return value ? *value : std::string();
}

std::string MjcfElement::where() const {
  std::string location = file ? quote(file->string()) : std::string("the model");
  location += ", line " + std::to_string(line) + ": " + kind;
  const std::string* const name = find("name");
  return name && !name->empty() ? location + " " + quote(*name) : location;
}

Result<MjcfElement> load_mjcf(const fs::path& file, MjcfFiles& files) {
  MjcfElement root;
  if (Result<void> done = Loader(file, files).load(file, root, true, 0); !done) return done.error();
  return root;
}

}  // namespace fire3dv::convert
