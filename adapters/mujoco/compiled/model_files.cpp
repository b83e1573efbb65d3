#include "adapters/mujoco/compiled/model_files.h"

#include <strings.h>
#include <tinyxml2.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <map>
#include <set>
#include <utility>

#include "convert/description_files.h"
#include "convert/xml_error.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxFiles = 100'000, kMaxIncludes = 1000;

enum class Use { mesh, skin, field, flat_texture, cube, further_side };

bool is_texture(Use use) {
  return use == Use::flat_texture || use == Use::cube || use == Use::further_side;
}

// libmujoco's test for file types: the ending needs no dot.
bool ends_with(const std::string& name, const char* ending) {
  const size_t length = std::strlen(ending);
  return name.size() >= length && strcasecmp(name.c_str() + name.size() - length, ending) == 0;
}

bool is_separator(char c) {
  return c == '/' || c == '\\';
}

// libmujoco's test for absolute paths, including Windows forms; those resolve against the working directory.
bool is_absolute(const std::string& name) {
  return (!name.empty() && is_separator(name.front())) || name.find(":/") != name.npos ||
         name.find(":\\") != name.npos;
}

class Files {
 public:
  Files(const fs::path& model, const std::vector<fs::path>& folders)
      : folder_(model.string().substr(0, model.string().rfind('/') + 1)) {
    allowed_.add(model.parent_path());
    std::error_code error;
    const fs::path own = fs::canonical(model, error);  // target folder, if the model is a symbolic link
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

  // libmujoco applies the last folder that any compiler element sets; all of them are checked.
  Result<Sources> found() {
    for (const auto& [named, times] : names_) {
      const auto& [use, name] = named;
      const std::set<std::string>& folders = is_texture(use) ? texture_folders_ : mesh_folders_;
      for (const std::string& below : folders)
        if (Result<void> done = add_use(use, name, below, times); !done) return done.error();
      if (!folders.empty()) continue;
      if (Result<void> done = add_use(use, name, "", times); !done) return done.error();
    }
    return std::move(sources_);
  }

 private:
  void include(const fs::path& file) {
    includes_.push_back(file);
    sources_.add(file);
  }

  void add(Use use, const std::string& value) {
    ++names_[{use, value}];
    const std::string stripped = value.substr(value.find_last_of("/\\") + 1);  // name with the strippath
                                                                               // option
    if (stripped != value) ++names_[{use, stripped}];
  }

  Result<void> add_use(Use use, const std::string& name, std::string below, uint64_t times) {
    if (!below.empty() && !is_separator(below.back())) below += '/';
    const fs::path path = is_absolute(name)    ? name
                          : is_absolute(below) ? below + name
                                               : folder_ + below + name;
    sources_.add(path);
    if (sources_.all().size() > kMaxFiles)
      return Error{"it names more than " + std::to_string(kMaxFiles) + " files"};
    if (Result<void> done = may_read(path); !done) return done;
    return scan_file(use, path, times);
  }

  // Validates contents that libmujoco would trust.
  Result<void> scan_file(Use use, const fs::path& path, uint64_t times) {
    constexpr uint64_t kMaxBytes = uint64_t{4} << 30;
    const std::string& name = path.native();
    const bool is_obj = use == Use::mesh && ends_with(name, "obj"),
               is_msh = use == Use::mesh && ends_with(name, "msh"), is_png = ends_with(name, ".png");
    std::error_code error;
    if ((use == Use::mesh && !is_obj && !is_msh) || !fs::is_regular_file(path, error)) return {};
    const Result<FileBytes> bytes = read_file(path, kMaxBytes);
    if (!bytes) return bytes.error();
    const std::string_view text(reinterpret_cast<const char*>(bytes->view().data()), bytes->view().size());
    const auto in_file = [&](const Result<void>& done) {
      return done ? done : Error{quote(path.string()) + " " + done.error().message};
    };
    if (is_obj) {
      const Result<void> whole = in_file(check_obj_faces(text));
      return whole ? scan_materials(path, text) : whole;
    }
    if (is_msh) return in_file(check_msh(text));
    if (use == Use::skin) return in_file(check_skn(text));
    if (use == Use::field) return in_file(amounts_.add_field(text, is_png, times));
    return in_file(amounts_.add_texture(text, is_png, texture_kind(use), times));
  }

  static MjcfTotals::Texture texture_kind(Use use) {
    return use == Use::flat_texture ? MjcfTotals::Texture::flat
           : use == Use::cube       ? MjcfTotals::Texture::cube
                                    : MjcfTotals::Texture::further_side;
  }

  Result<void> scan_materials(const fs::path& path, std::string_view text) {
    const Result<std::vector<std::string>> libraries = obj_material_files(text);
    if (!libraries) return Error{quote(path.string()) + " " + libraries.error().message};
    for (const std::string& library : *libraries) {
      for (const fs::path& candidate : obj_material_paths(path.string(), library)) {
        if (Result<void> done = may_read(candidate); !done) return done;
        sources_.add(candidate);
      }
    }
    return {};
  }

  // Missing files are allowed; libmujoco reports them.
  Result<void> may_read(const fs::path& path) const {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status) || fs::is_directory(status)) return {};
    const Result<fs::path> file = regular_file(path);
    if (!file) return file.error();
    if (allowed_.hold(*file)) return {};
    return Error{"it names " + quote(tidy_path(path).string()) +
                 ", which lies outside the model's folder: copy it there, or name its folder with "
                 "--package-path"};
  }

  Result<void> read_one(const fs::path& file) {
    std::error_code error;
    // Missing includes are allowed; libmujoco reports them, if it reads them at all.
    if (includes_.size() > 1 && !fs::exists(file, error)) return {};
    const Result<std::string> text = read_text(file);
    if (!text) return text.error();
    const Result<std::string> root_name = xml_root(*text);
    if (!root_name) return Error{quote(file.string()) + ": " + root_name.error().message};
    if (root_name->empty()) return Error{quote(file.string()) + " holds no XML element"};
    tinyxml2::XMLDocument document;  // libmujoco's parser, in the same version
    if (document.Parse(text->c_str()) != tinyxml2::XML_SUCCESS)
      return Error{quote(file.string()) + ", " + xml_error(document)};
    const tinyxml2::XMLElement* const root = document.RootElement();
    if (!root) return Error{quote(file.string()) + " holds no XML element"};
    if (Result<void> done = visit(*root); !done)
      return Error{quote(file.string()) + ": " + done.error().message};
    return {};
  }

  Result<void> visit(const tinyxml2::XMLElement& element) {  // recursion depth is bounded by xml_root()
    const std::string_view kind = element.Value();
    const bool is_include =
        strcasecmp(element.Value(), "include") == 0;  // libmujoco matches this element case-insensitively
    bool has_cube = false;
    for (const tinyxml2::XMLAttribute* a = element.FirstAttribute(); a; a = a->Next()) {
      const std::string name = a->Name(), value = a->Value();
      const bool is_folder = kind == "compiler" && name.ends_with("dir"), is_file = name.starts_with("file");
      if (!is_folder && (!is_file || value.empty())) continue;
      // Two XML parsers may read such a name differently.
      if (std::any_of(value.begin(), value.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
        return Error{"it names " + quote(value) + ", a name with control characters: rename it"};
      if (is_folder) {
        if (name == "meshdir" || name == "assetdir") mesh_folders_.insert(value);
        if (name == "texturedir" || name == "assetdir") texture_folders_.insert(value);
      } else if (is_include) {
        const fs::path path = folder_ + value;  // libmujoco resolves includes against this folder only
        if (sources_.contains(path)) continue;  // libmujoco refuses it with a message
        if (includes_.size() == kMaxIncludes)
          return Error{"it includes more than " + std::to_string(kMaxIncludes) + " files"};
        if (Result<void> done = may_read(path); !done) return done;
        include(path);
      } else if (kind == "texture") {
        add(texture_use(element, name, std::exchange(has_cube, true)), value);
      } else {
        add(kind == "skin" ? Use::skin : kind == "hfield" ? Use::field : Use::mesh, value);
      }
    }
    if (Result<void> done = check_numbers(element); !done) return done;
    for (const tinyxml2::XMLElement* child = element.FirstChildElement(); child;
         child = child->NextSiblingElement()) {
      if (Result<void> done = visit(*child); !done) return done;
    }
    return {};
  }

  static Use texture_use(const tinyxml2::XMLElement& element, const std::string& attribute, bool has_cube) {
    if (attribute_of(element, "type") == "2d") return Use::flat_texture;
    return attribute != "file" && has_cube ? Use::further_side : Use::cube;
  }

  static std::string attribute_of(const tinyxml2::XMLElement& element, const char* name) {
    const char* const value = element.Attribute(name);
    return value ? value : "";
  }

  // Validates inline data of elements.
  Result<void> check_numbers(const tinyxml2::XMLElement& element) {
    const std::string_view kind = element.Value();
    const auto number = [&](const char* name) {  // parses exactly like libmujoco
      return static_cast<int>(std::strtol(attribute_of(element, name).c_str(), nullptr, 10));
    };
    const auto in_file = [&](const Result<void>& done) {
      return done ? done
                  : Error{"its " + std::string(kind) + " " + quote(attribute_of(element, "name")) + " " +
                          done.error().message};
    };
    if (kind == "hfield") return in_file(amounts_.add_field(number("nrow"), number("ncol")));
    if (kind == "texture") {
      const bool is_flat = attribute_of(element, "type") == "2d";
      return in_file(amounts_.add_texture(number("width"), number("height"),
                                          is_flat ? MjcfTotals::Texture::flat : MjcfTotals::Texture::cube));
    }
    if ((kind != "mesh" && kind != "skin") || !element.Attribute("face")) return {};
    if (element.Attribute("file"))
      return in_file(Error{"has a file and faces of its own: leave out one of them"});
    return in_file(check_inline_faces(attribute_of(element, "vertex"), attribute_of(element, "face")));
  }

  std::string folder_;  // prefix that libmujoco adds to names
  AllowedFolders allowed_;
  std::vector<fs::path> includes_;
  Sources sources_;
  std::map<std::pair<Use, std::string>, uint64_t> names_;  // number of uses
  std::set<std::string> mesh_folders_, texture_folders_;
  MjcfTotals amounts_;
};

}  // namespace

Result<Sources> mjcf_files(const std::filesystem::path& model,
                           const std::vector<std::filesystem::path>& folders) {
  const auto in_file = [&](const Error& error) {
    return Error{quote(model.string()) + ": " + error.message};
  };
  // libmujoco would treat the part before a backslash as a folder.
  if (model.filename().native().find('\\') != std::string::npos)
    return in_file(Error{"its name holds a backslash: rename it"});
  Files files(model, folders);
  if (Result<void> done = files.read(model); !done) return done.error();
  Result<Sources> found = files.found();
  if (!found) return in_file(found.error());
  return found;
}

}  // namespace fire3dv::convert
