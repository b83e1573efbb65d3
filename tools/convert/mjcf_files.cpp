#include "tools/convert/mjcf_files.h"

#include <tinyxml.h>

#include <set>
#include <string_view>

#include "renderer/scene/files.h"
#include "tools/convert/description_kind.h"
#include "tools/convert/local_files.h"
#include "tools/convert/obj_faces.h"
#include "tools/convert/obj_materials.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostFiles = 100'000, kMostIncludes = 1000;

// What names of one kind are looked for: libmujoco takes the last folder that any compiler element gives.
struct Named {
  std::set<std::string> names, folders;

  void add(const std::string& value) {
    names.insert(value);
    names.insert(value.substr(value.find_last_of("/\\") + 1));  // what strippath leaves
  }
};

class Files {
 public:
  Files(const fs::path& model, const std::vector<fs::path>& folders) : folder_(model.parent_path()) {
    allowed_.add(folder_);
    std::error_code error;
    const fs::path own = fs::canonical(model, error);  // where a link to it leads
    if (!error) allowed_.add(own.parent_path());
    for (const fs::path& folder : folders) allowed_.add(folder);
  }

  Result<void> read(const fs::path& file) {
    include(file);
    for (size_t i = 0; i < includes_.size(); ++i) {
      if (Result<void> done = read_one(includes_[i]); !done) return done;
    }
    return {};
  }

  Result<Sources> found() {
    for (const Named* kind : {&meshes_, &textures_}) {
      for (const std::string& name : kind->names) {
        for (const std::string& below : kind->folders)
          if (Result<void> done = look(name, below); !done) return done.error();
        if (!kind->folders.empty()) continue;
        if (Result<void> done = look(name, ""); !done) return done.error();
      }
    }
    return std::move(sources_);
  }

 private:
  void include(const fs::path& file) {
    includes_.push_back(file);
    sources_.add(file);
  }

  Result<void> look(const std::string& name, const std::string& below) {
    // A name that begins like one of Windows is absolute for libmujoco, and so leads to where this program
    // was started.
    const fs::path path = is_absolute(name)    ? fs::path(name)
                          : is_absolute(below) ? fs::path(below) / name
                                               : folder_ / below / name;
    if (sources_.contains(path)) return {};
    sources_.add(path);
    if (sources_.all().size() > kMostFiles)
      return Error{"it names more than " + std::to_string(kMostFiles) + " files"};
    if (Result<void> done = may_read(path); !done) return done;
    return is_obj(path) ? look_into_obj(path) : Result<void>();
  }

  Result<void> look_into_obj(const fs::path& path) {
    constexpr uint64_t kMostBytes = uint64_t{4} << 30;
    std::error_code error;
    if (!fs::is_regular_file(path, error)) return {};
    const Result<scene::Bytes> bytes = scene::read_file(path, kMostBytes);
    if (!bytes) return bytes.error();
    const std::string_view text(reinterpret_cast<const char*>(bytes->view().data()), bytes->view().size());
    const auto told = [&](const Error& fault) {
      return Error{scene::quote(path.string()) + " " + fault.message};
    };
    if (Result<void> whole = check_obj_faces(text); !whole) return told(whole.error());
    const Result<std::vector<std::string>> libraries = obj_material_files(text);
    if (!libraries) return told(libraries.error());
    for (const std::string& library : *libraries) {
      const fs::path beside = path.parent_path() / fs::path(library).relative_path();
      if (Result<void> done = may_read(beside); !done) return done;
      sources_.add(beside);
    }
    return {};
  }

  static bool is_absolute(const std::string& name) {
    return name.starts_with('/') || name.starts_with('\\') || (name.size() > 1 && name[1] == ':');
  }

  // What is not there may be read: libmujoco says that it is missing.
  Result<void> may_read(const fs::path& path) const {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status) || fs::is_directory(status)) return {};
    const Result<fs::path> file = regular_file(path);
    if (!file) return file.error();
    if (allowed_.hold(*file)) return {};
    return Error{"it names " + scene::quote(tidy_path(path).string()) +
                 ", which lies outside the model's folder: copy it there, or name its folder with "
                 "--package-path"};
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
      if (kind == "compiler") {
        if (name == "meshdir" || name == "assetdir") meshes_.folders.insert(value);
        if (name == "texturedir" || name == "assetdir") textures_.folders.insert(value);
      }
      if (!name.starts_with("file") || value.empty()) continue;
      if (kind == "include") {
        const fs::path path = folder_ / fs::path(value).relative_path();  // libmujoco knows no other
        if (sources_.contains(path)) continue;  // libmujoco refuses it with a reason
        if (includes_.size() == kMostIncludes)
          return Error{"it includes more than " + std::to_string(kMostIncludes) + " files"};
        if (Result<void> done = may_read(path); !done) return done;
        include(path);
      } else {
        (kind == "texture" ? textures_ : meshes_).add(value);
      }
    }
    for (const TiXmlElement* child = element.FirstChildElement(); child;
         child = child->NextSiblingElement()) {
      if (Result<void> done = visit(*child); !done) return done;
    }
    return {};
  }

  fs::path folder_;
  AllowedFolders allowed_;
  std::vector<fs::path> includes_;
  Sources sources_;
  Named meshes_, textures_;
};

}  // namespace

Result<Sources> mjcf_files(const std::filesystem::path& model,
                           const std::vector<std::filesystem::path>& folders) {
  const auto told = [&](const Error& error) {
    return Error{scene::quote(model.string()) + ": " + error.message};
  };
  Files files(model, folders);
  if (Result<void> done = files.read(model); !done) return done.error();
  Result<Sources> found = files.found();
  if (!found) return told(found.error());
  return found;
}

}  // namespace fire3dv::convert
