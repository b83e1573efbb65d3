#include "renderer/editing/document_additions.h"

namespace fire3dv::state {
namespace {

std::map<std::string, std::string> paths_of_additions(const EditDocument& document) {
  std::map<std::string, std::string> names;  // by path
  for (const auto& [key, value] : document) {
    if (const auto* const addition = std::get_if<Addition>(&value))
      names.emplace(path_of(key.name, *addition), key.name);
  }
  return names;
}

}  // namespace

bool is_at_or_below(std::string_view path, const Paths& tops) {
  for (size_t end = path.find('/'); end != std::string_view::npos; end = path.find('/', end + 1)) {
    if (tops.contains(path.substr(0, end))) return true;
  }
  return tops.contains(path);
}

std::string addition_at(const Additions& additions, std::string_view path) {
  for (const auto& [name, addition] : additions) {
    if (path_of(name, addition) == path) return name;
  }
  return {};
}

bool withdraw_removed_additions(EditDocument& document, const Paths& shown) {
  const std::map<std::string, std::string> additions = paths_of_additions(document);
  Paths removed;
  for (const auto& [key, value] : document) {
    if (key.object == EditedObject::node && key.occurrence == 0 && !key.instance &&
        key.property == EditedProperty::removed && additions.contains(key.name) && shown.contains(key.name))
      removed.insert(key.name);
  }
  if (removed.empty()) return false;
  const auto is_gone = [&](const std::string& path) { return is_at_or_below(path, removed); };
  std::set<std::string_view> gone;  // names of additions
  for (const auto& [path, name] : additions) {
    if (is_gone(path)) gone.insert(name);
  }
  std::erase_if(document, [&](const auto& edit) {
    if (edit.first.object == EditedObject::node) return is_gone(edit.first.name);
    if (edit.first.object == EditedObject::material) return gone.contains(edit.first.owner);
    return edit.first.object == EditedObject::addition && gone.contains(edit.first.name);
  });
  return true;
}

EditDocument edits_of_copy(const EditDocument& document, const std::string& source, const std::string& copy) {
  Paths left_out;  // other additions below the source
  for (const auto& [path, name] : paths_of_additions(document)) {
    if (path != source && is_at_or_below(path, source)) left_out.insert(path);
  }
  EditDocument edits;
  for (const auto& [key, value] : document) {
    if (key.object != EditedObject::node || !is_at_or_below(key.name, source)) continue;
    const bool is_of_root = key.name.size() == source.size() && !key.instance;
    if (is_of_root && (key.property == EditedProperty::transform || key.property == EditedProperty::removed))
      continue;
    if (is_at_or_below(key.name, left_out)) continue;
    EditKey of_copy = key;
    of_copy.name = copy + key.name.substr(source.size());
    edits.emplace(std::move(of_copy), value);
  }
  return edits;
}

EditDocument material_edits_of_copy(const EditDocument& document, const std::string& owner,
                                    const std::string& copy) {
  EditDocument edits;
  for (const auto& [key, value] : document) {
    if (key.object != EditedObject::material || key.owner != owner) continue;
    EditKey of_copy = key;
    of_copy.owner = copy;
    edits.emplace(std::move(of_copy), value);
  }
  return edits;
}

}  // namespace fire3dv::state
