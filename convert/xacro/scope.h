// Scopes of xacro: properties, blocks and macros by name. A macro call sees the names of its caller, since
// xacro scopes are dynamic.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "convert/xacro/document.h"
#include "convert/xacro/expression/value.h"

namespace fire3dv::convert::xacro {

struct Property {
  Value value;
  bool is_lazy = false;  // text that is evaluated on first use
  bool is_being_evaluated = false;
};

// Elements for xacro:insert_block.
using Block = std::shared_ptr<const std::vector<Element>>;

struct Parameter {
  std::string name;  // of a block: with its asterisks
  bool has_default = false;
  bool is_forwarded = false;  // ^: the caller's property of that name
  std::optional<std::string> fallback;
};

struct Macro {
  std::shared_ptr<const Element> body;
  std::vector<Parameter> parameters;
};

class Scope {
 public:
  explicit Scope(Scope* outer, bool is_name_space = false) : parent(outer), is_namespace(is_name_space) {}

  // The nearest scope at or above this one that has the property; null if there is none.
  Scope* owner_of(const std::string& name) {
    for (Scope* scope = this; scope; scope = scope->parent)
      if (scope->properties.contains(name)) return scope;
    return nullptr;
  }
  const Block* block(const std::string& name) const {
    for (const Scope* scope = this; scope; scope = scope->parent)
      if (const auto known = scope->blocks.find(name); known != scope->blocks.end()) return &known->second;
    return nullptr;
  }
  const std::shared_ptr<const Macro>* macro(const std::string& name) const {
    for (const Scope* scope = this; scope; scope = scope->parent)
      if (const auto known = scope->macros.find(name); known != scope->macros.end()) return &known->second;
    return nullptr;
  }

  Scope* const parent;
  const bool is_namespace;
  std::map<std::string, Property> properties;
  std::map<std::string, Block> blocks;  // by name with asterisks
  std::map<std::string, std::shared_ptr<const Macro>> macros;
};

// Parses the attribute `params` of a macro: NAME, NAME:=DEFAULT, NAME:=^, NAME:=^|DEFAULT, *BLOCK, **BLOCK.
std::vector<Parameter> parse_parameters(const std::string& text);

}  // namespace fire3dv::convert::xacro
