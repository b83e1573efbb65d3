// Additions in an edit document: what a removal and a copy change beside the addition itself.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "renderer/editing/edit_document.h"

namespace fire3dv::state {

inline EditKey key_of_addition(std::string name) {
  return {EditedObject::addition, std::move(name), 0, EditedProperty::added};
}

// Paths of nodes.
using Paths = std::set<std::string, std::less<>>;
// True if the path is one of these, or below one.
bool is_at_or_below(std::string_view path, const Paths& tops);

// Name of the addition whose node has this path; empty: none.
std::string addition_at(const Additions& additions, std::string_view path);

// A removed addition is none any more, and neither are additions and edits of nodes below it, and edits of
// the materials of these. shown: paths of
// additions whose nodes are displayed; a removed node at the path of another one is of the file, and stays
// removed. Returns true if there were any.
bool withdraw_removed_additions(EditDocument& document, const Paths& shown);

// Edits of the nodes at and below a path, for a copy at another path: without transform and removal of the
// first node, which has its own.
EditDocument edits_of_copy(const EditDocument& document, const std::string& source, const std::string& copy);
// Edits of the materials of an added file, for another addition of that file, which has materials of its own.
EditDocument material_edits_of_copy(const EditDocument& document, const std::string& owner,
                                    const std::string& copy);

}  // namespace fire3dv::state
