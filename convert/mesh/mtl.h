// MTL reader: the materials of OBJ files by name, with texture options. Never fails: lines that it does not
// understand are skipped.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "convert/mesh/mesh_import.h"

namespace fire3dv::convert {

class MtlMaterials {
 public:
  // Adds the materials of a file. A name that is known already gets the properties of both. folder: of the
  // file, relative to that of the OBJ file; images are beside the file.
  void add(std::string_view text, const std::string& folder = {});

  bool contains(std::string_view name) const { return entries_.contains(name); }
  // name: known.
  ImportedMaterial material(std::string_view name) const;
  // MTL file with the names alone, for importers that need a file but not its values.
  std::string names() const;
  // Properties that are not drawn: one line for each kind.
  std::vector<std::string> warnings() const;

 private:
  struct Entry {
    ImportedMaterial material;
    bool has_diffuse = false, has_dissolve = false, has_roughness = false, has_specular = false;
    float specular_exponent = 0;
  };
  struct Omission {
    std::string first;  // material
    size_t count = 0;   // of materials
  };

  void set(const std::string& keyword, std::string_view rest, Entry& to);
  void set_map(const std::string& keyword, std::string_view rest, Entry& to);
  void leave_out(const std::string& what, const std::string& material);

  std::string folder_;  // of the current file
  std::map<std::string, Entry, std::less<>> entries_;
  std::map<std::string, Omission> omissions_;
};

}  // namespace fire3dv::convert
