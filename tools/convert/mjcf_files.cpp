#include "tools/convert/mjcf_files.h"

#include <tinyxml.h>

#include <set>

#include "renderer/scene/files.h"
#include "tools/convert/description_kind.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostFiles = 100'000, kMostIncludes = 1000;

class Files {
 public:
  explicit Files(const fs::path& model) : folder_(model.parent_path()) {}

  Result<void> read(const fs::path& file) {
    include(file);
    for (size_t i = 0; i < includes_.size(); ++i) {
      if (Result<void> done = read_one(includes_[i]); !done) return done;
    }
    return {};
  }

  Result<Sources> found() {
    for (const std::string& name : names_) {
      for (const std::string& below : folders_) {
        const fs::path path = folder_ / below / name;
        if (sources_.contains(path)) continue;
        sources_.add(path);
        std::error_code error;
        const fs::file_status status = fs::status(path, error);
        if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status))
          return Error{scene::quote(path.string()) + " is not a regular file"};
        if (sources_.all().size() > kMostFiles)
          return Error{"it names more than " + std::to_string(kMostFiles) + " files"};
      }
    }
    return std::move(sources_);
  }

 private:
  void include(const fs::path& file) {
    includes_.push_back(file);
    sources_.add(file);
  }

  Result<void> read_one(const fs::path& file) {
    std::error_code error;
    // libmujoco says what it thinks of an include that is not there, if it looks there at all.
    if (includes_.size() > 1 && !fs::exists(file, error)) return {};
    const Result<std::string> text = read_text(file);
    if (!text) return text.error();
    const Result<std::string> root_name = xml_root(*text);
    if (!root_name) return Error{scene::quote(file.string()) + ": " + root_name.error().message};
    if (root_name->empty()) return Error{scene::quote(file.string()) + " holds no XML element"};
    TiXmlDocument document;
    document.Parse(text->c_str());
    if (document.Error()) {
      return Error{scene::quote(file.string()) + ", line " + std::to_string(document.ErrorRow()) + ": " +
                   document.ErrorDesc()};
    }
    if (const TiXmlElement* root = document.RootElement()) return visit(*root);
    return Error{scene::quote(file.string()) + " holds no XML element"};
  }

  Result<void> visit(const TiXmlElement& element) {  // no deeper than xml_root() lets pass
    const std::string_view kind = element.Value();
    for (const TiXmlAttribute* a = element.FirstAttribute(); a; a = a->Next()) {
      const std::string name = a->Name(), value = a->Value();
      if (kind == "compiler" && (name == "meshdir" || name == "texturedir" || name == "assetdir"))
        folders_.insert(value);
      if (!name.starts_with("file") || value.empty()) continue;
      if (kind == "include") {
        const fs::path path = folder_ / value;
        if (sources_.contains(path)) continue;  // libmujoco refuses it with a reason
        if (includes_.size() == kMostIncludes)
          return Error{"it includes more than " + std::to_string(kMostIncludes) + " files"};
        include(path);
      } else {
        names_.insert(value);
        names_.insert(fs::path(value).filename().string());  // what strippath leaves
      }
    }
    for (const TiXmlElement* child = element.FirstChildElement(); child;
         child = child->NextSiblingElement()) {
      if (Result<void> done = visit(*child); !done) return done;
    }
    return {};
  }

  fs::path folder_;
  std::vector<fs::path> includes_;
  Sources sources_;
  std::set<std::string> names_, folders_{""};
};

}  // namespace

Result<Sources> mjcf_files(const std::filesystem::path& model) {
  Files files(model);
  if (Result<void> done = files.read(model); !done) return done.error();
  Result<Sources> found = files.found();
  if (!found) return Error{scene::quote(model.string()) + ": " + found.error().message};
  return found;
}

}  // namespace fire3dv::convert
