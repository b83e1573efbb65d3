#include "convert/xacro/expander.h"

#include <algorithm>
#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "convert/description_files.h"
#include "convert/xacro/scope.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert::xacro {
namespace {

namespace fs = std::filesystem;

bool is_identifier(std::string_view name) {
  const auto is_letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' ||
           static_cast<unsigned char>(c) >= 0x80;
  };
  return !name.empty() && is_letter(name[0]) && std::all_of(name.begin(), name.end(), [&](char c) {
    return is_letter(c) || (c >= '0' && c <= '9');
  });
}

// Expands elements by appending to an output element: the input stays unchanged, so a macro's body serves any
// number of calls.
class Expander {
 public:
  Expander(Substitution& substitution, Budget& budget) : substitution_(substitution), budget_(budget) {}

  Element expand_document(const Element& root) {
    Element out = copy_without_children(root, global_);
    if (const std::string* name_space = root.attribute("xacro:targetNamespace"))
      out.set("xmlns", *name_space);
    expand_children(root, out, global_);
    return out;
  }

 private:
  // Elements of xacro, by the name behind "xacro:".
  enum class Keyword {
    none,
    property,
    macro,
    arg,
    include,
    insert_block,
    condition,
    element,
    attribute,
    call
  };

  static Keyword keyword_of(const std::string& name) {
    constexpr std::array<std::pair<std::string_view, Keyword>, 10> kNames = {
        {{"property", Keyword::property},
         {"macro", Keyword::macro},
         {"arg", Keyword::arg},
         {"include", Keyword::include},
         {"insert_block", Keyword::insert_block},
         {"if", Keyword::condition},
         {"unless", Keyword::condition},
         {"element", Keyword::element},
         {"attribute", Keyword::attribute},
         {"call", Keyword::call}}};
    if (!name.starts_with("xacro:")) return Keyword::none;
    for (const auto& [known, keyword] : kNames)
      if (std::string_view(name).substr(6) == known) return keyword;
    return Keyword::call;
  }

  Element copy_without_children(const Element& from, Scope& scope) {
    Element to;
    to.name = from.name;
    to.file = from.file;
    to.line = from.line;
    for (const auto& [name, value] : from.attributes) {
      if (name.starts_with("xacro:") || name == "xmlns:xacro") continue;
      budget_.step();
      try {
        to.attributes.emplace_back(name, substitution_.evaluate_to_text(value, scope));
      } catch (Failure& failure) {
        failure.locate(from.location() + ", attribute " + name);
        throw;
      }
    }
    budget_.bytes(sizeof(Element));
    return to;
  }

  void expand_children(const Element& from, Element& to, Scope& scope) {
    for (const Element& child : from.children) {
      budget_.step();
      try {
        if (child.is_text())
          add_text(child, to, scope);
        else
          expand_element(child, to, scope);
      } catch (Failure& failure) {
        failure.locate(child.location());
        throw;
      }
    }
  }

  void add_text(const Element& text, Element& to, Scope& scope) {
    Element made = text;
    if (!text.is_cdata) made.text = substitution_.evaluate_to_text(text.text, scope);
    budget_.bytes(sizeof(Element) + made.text.size());
    to.children.push_back(std::move(made));
  }

  void expand_element(const Element& from, Element& to, Scope& scope) {
    const Budget::Level level(budget_);
    switch (keyword_of(from.name)) {
      case Keyword::none: {
        Element made = copy_without_children(from, scope);
        expand_children(from, made, scope);
        to.children.push_back(std::move(made));
        return;
      }
      case Keyword::property:
        return set_property(from, scope);
      case Keyword::macro:
        return define_macro(from, scope);
      case Keyword::arg:
        return substitution_.set_default_argument(
            required(from, "name"), substitution_.evaluate_to_text(required(from, "default"), scope));
      case Keyword::include:
        return include(from, to, scope);
      case Keyword::insert_block:
        return insert_block(from, to, scope);
      case Keyword::condition:
        return expand_condition(from, to, scope);
      case Keyword::element: {
        Element renamed = from;
        charge(from, budget_);
        renamed.name = substitution_.evaluate_to_text(required(from, "xacro:name"), scope);
        if (renamed.name.empty()) throw Failure("the name is empty");
        return expand_element(renamed, to, scope);
      }
      case Keyword::attribute: {
        const std::string name = substitution_.evaluate_to_text(required(from, "name"), scope);
        if (name.empty()) throw Failure("the name is empty");
        return to.set(name, substitution_.evaluate_to_text(required(from, "value"), scope));
      }
      case Keyword::call:
        break;
    }
    call_macro(from, to, scope);
  }

  static const std::string& required(const Element& element, const std::string& attribute) {
    const std::string* value = element.attribute(attribute);
    if (!value) throw Failure("the attribute " + attribute + " is missing");
    return *value;
  }

  std::string evaluated(const Element& element, const std::string& attribute, const std::string& otherwise,
                        Scope& scope) {
    const std::string* value = element.attribute(attribute);
    return substitution_.evaluate_to_text(value ? *value : otherwise, scope);
  }

  // Moves the evaluated content of a condition, include or macro to the position of its element. Attributes
  // of the content's own element are dropped, except namespaces where xacro lifts them.
  void lift(Element content, Element& to, bool with_namespaces) {
    if (with_namespaces)
      for (auto& [name, value] : content.attributes)
        if (name.starts_with("xmlns:") && !to.attribute(name)) to.set(name, value);
    for (Element& child : content.children) to.children.push_back(std::move(child));
  }

  void expand_condition(const Element& from, Element& to, Scope& scope) {
    const std::string condition = required(from, "value");
    const bool value = Substitution::boolean(substitution_.evaluate_text(condition, scope), condition);
    if (value != (from.name == "xacro:if")) return;
    Element content;
    expand_children(from, content, scope);
    lift(std::move(content), to, false);
  }

  void set_property(const Element& from, Scope& scope) {
    const std::string name = substitution_.evaluate_to_text(required(from, "name"), scope);
    if (!is_identifier(name))
      throw Failure(quote(name) + " is not a name of a property: letters, digits and _");
    if (name.starts_with("__")) throw Failure("names of properties do not begin with __");
    const std::string *value = from.attribute("value"), *fallback = from.attribute("default");
    const std::string* where = from.attribute("scope");
    const bool removes = Substitution::boolean(evaluated(from, "remove", "false", scope), "remove");
    if ((value != nullptr) + (fallback != nullptr) + removes > 1)
      throw Failure("value, default and remove exclude each other");
    if (removes) {
      for (Scope* each = &scope; each; each = each->parent) each->properties.erase(name);
      return;
    }
    if (fallback) {
      if (scope.owner_of(name)) return;
      value = fallback;
    }
    bool lazy = Substitution::boolean(evaluated(from, "lazy_eval", "true", scope), "lazy_eval");
    Scope* target = &scope;
    if (where && *where == "global") {
      while (target->parent) target = target->parent;
      lazy = false;
    } else if (where && *where == "parent") {
      if (!scope.parent) throw Failure("the outermost scope has no parent");
      target = scope.parent;
      if (!scope.is_namespace)
        while (target->is_namespace && target->parent) target = target->parent;
      lazy = false;
    }
    if (!value) {
      charge(from, budget_);
      target->blocks["**" + name] = std::make_shared<const std::vector<Element>>(from.children);
      return;
    }
    Value typed = *value;
    if (!lazy) typed = substitution_.evaluate_text(*value, scope);
    store(*target, name, std::move(typed), lazy);
  }

  // Text is read as a number or boolean where it is one.
  void store(Scope& scope, const std::string& name, Value value, bool lazy) {
    if (const std::string* text = value.as<std::string>()) value = literal(std::string(*text));
    budget_.bytes(sizeof(Property) + name.size() + 64);
    const bool is_text = value.as<std::string>() != nullptr;
    scope.properties[name] = {std::move(value), lazy && is_text, false};
  }

  void define_macro(const Element& from, Scope& scope) {
    std::string name = required(from, "name");
    if (name.starts_with("xacro:")) name.erase(0, 6);
    if (name == "call") throw Failure("a macro cannot have the name call");
    if (name.find('.') != std::string::npos)
      throw Failure("names of macros have no '.', which separates namespaces");
    charge(from, budget_);
    auto macro = std::make_shared<Macro>();
    macro->body = std::make_shared<const Element>(from);
    if (const std::string* parameters = from.attribute("params"))
      macro->parameters = parse_parameters(*parameters);
    scope.macros[name] = std::move(macro);
  }

  // Finds NAME, or NAME in a namespace: A.B.NAME. The macro of a namespace sees the namespace's properties.
  // Null for an unknown macro that is ignored.
  std::pair<const Macro*, Scope*> find_macro(const std::string& full_name, Scope& scope) {
    if (const auto* macro = scope.macro(full_name)) return {keep(*macro), &scope};
    Scope* at = &scope;
    size_t begin = 0;
    for (size_t dot = full_name.find('.'); dot != std::string::npos; dot = full_name.find('.', begin)) {
      const std::optional<Value> inner = property_of(*at, full_name.substr(begin, dot - begin));
      Scope* const* next = inner ? inner->as<Scope*>() : nullptr;
      if (!next) break;
      at = *next;
      begin = dot + 1;
    }
    if (begin > 0)
      if (const auto* macro = at->macro(full_name.substr(begin))) return {keep(*macro), at};
    const std::string message =
        "there is no macro " + quote(full_name) + "; is the file that defines it included?";
    if (!substitution_.ignores_unknown_macros()) throw Failure(message);
    substitution_.warn(message + " The element is left out");
    return {nullptr, nullptr};
  }

  // A macro may be redefined while it is called.
  const Macro* keep(const std::shared_ptr<const Macro>& macro) {
    called_.push_back(macro);
    return macro.get();
  }

  std::optional<Value> property_of(Scope& scope, const std::string& name) {
    return substitution_.property(&scope, name);
  }

  void call_macro(const Element& from, Element& to, Scope& caller) {
    const bool is_dynamic = from.name == "xacro:call";
    const std::string name =
        is_dynamic ? substitution_.evaluate_to_text(required(from, "macro"), caller) : from.name.substr(6);
    const auto [macro, definition_scope] = find_macro(name, caller);
    if (!macro) return;
    // Arguments, blocks and defaults are the caller's, as in xacro 2.1; the body sees the namespace of the
    // macro.
    Scope& local = add_scope(definition_scope, false);

    std::vector<const Parameter*> left;
    for (const Parameter& parameter : macro->parameters) left.push_back(&parameter);
    for (const auto& [attribute, value] : from.attributes) {
      if ((is_dynamic && attribute == "macro") || attribute.starts_with("xmlns:")) continue;
      const auto parameter =
          std::find_if(left.begin(), left.end(),
                       [&, &wanted = attribute](const Parameter* p) { return p->name == wanted; });
      if (parameter == left.end()) throw Failure("the macro has no parameter " + quote(attribute));
      left.erase(parameter);
      store(local, attribute, substitution_.evaluate_text(value, caller), false);
    }
    take_blocks(from, left, local, caller);
    for (const Parameter* parameter : left) set_default(*parameter, local, caller);

    Element content;
    try {
      expand_children(*macro->body, content, local);
    } catch (Failure& failure) {
      failure.add_call("the macro of line " + std::to_string(from.line) + ", " + from.name);
      throw;
    }
    for (const auto& [attribute, value] : macro->body->attributes)
      if (attribute.starts_with("xmlns:") && attribute != "xmlns:xacro")
        content.attributes.emplace_back(attribute, value);
    lift(std::move(content), to, true);
    called_.pop_back();
  }

  // Assigns the evaluated child elements of a call to the block parameters in order.
  void take_blocks(const Element& from, std::vector<const Parameter*>& left, Scope& local, Scope& caller) {
    Element content;
    expand_children(from, content, caller);
    std::erase_if(content.children, [](const Element& child) { return child.is_text(); });
    size_t next = 0;
    std::erase_if(left, [&](const Parameter* parameter) {
      if (!parameter->name.starts_with('*')) return false;
      if (next == content.children.size())
        throw Failure("the call has too few elements inside: the block " + parameter->name + " is missing");
      Element& block = content.children[next++];
      std::vector<Element> elements;
      if (parameter->name.starts_with("**"))
        elements = std::move(block.children);
      else
        elements.push_back(std::move(block));
      local.blocks[parameter->name] = std::make_shared<const std::vector<Element>>(std::move(elements));
      return true;
    });
    if (next < content.children.size())
      throw Failure("the macro takes no block <" + content.children[next].name + ">");
  }

  void set_default(const Parameter& parameter, Scope& local, Scope& caller) {
    const std::string& name = parameter.name;
    if (parameter.is_forwarded) {
      if (std::optional<Value> value = property_of(caller, name))
        return store(local, name, std::move(*value), false);
      if (!parameter.fallback)
        throw Failure("the caller has no property " + name + " for the parameter of that name");
    }
    if (!parameter.fallback) throw Failure("the parameter " + name + " has no value");
    store(local, name, substitution_.evaluate_text(*parameter.fallback, caller), false);
  }

  void insert_block(const Element& from, Element& to, Scope& scope) {
    const std::string name = required(from, "name");
    const Block* block = scope.block("**" + name);
    if (!block) block = scope.block("*" + name);
    if (!block) throw Failure("there is no block " + quote(name));
    const Block held = *block;  // insertion may redefine it
    Element source;
    source.children = *held;
    charge(source, budget_);
    Element content;
    expand_children(source, content, scope);
    lift(std::move(content), to, false);
  }

  void include(const Element& from, Element& to, Scope& scope) {
    Scope* target = &scope;
    if (const std::string* name_space = from.attribute("ns")) {
      target = &add_scope(&scope, true);
      scope.properties[substitution_.evaluate_to_text(*name_space, scope)] = {Value(target), false, false};
    }
    const bool optional = Substitution::boolean(evaluated(from, "optional", "false", scope), "optional");
    const std::string name = substitution_.evaluate_to_text(required(from, "filename"), scope);
    for (const std::string& file : substitution_.expand_pattern(name)) {
      try {
        include_file(substitution_.readable_file(file), to, *target);
      } catch (const Failure& failure) {
        if (!optional || failure.kind() != Failure::Kind::missing_file) throw;
      }
    }
  }

  void include_file(const fs::path& path, Element& to, Scope& scope) {
    const Result<std::string> text = read_text(path);
    if (!text) throw Failure(text.error().message);
    const Result<Element> root = parse_document(path, *text);
    if (!root) throw Failure(root.error().message);
    charge(*root, budget_);
    substitution_.push_file(path);
    Element content = copy_without_children(*root, scope);
    expand_children(*root, content, scope);
    substitution_.pop_file();
    lift(std::move(content), to, true);
  }

  // Scopes live as long as the expansion, since a namespace can outlive its element.
  Scope& add_scope(Scope* parent, bool is_namespace) {
    budget_.bytes(sizeof(Scope) + 64);
    return scopes_.emplace_back(parent, is_namespace);
  }

  Substitution& substitution_;
  Budget& budget_;
  Scope global_{nullptr};
  std::deque<Scope> scopes_;
  std::vector<std::shared_ptr<const Macro>> called_;
};

}  // namespace

Element expand(const Element& root, Substitution& substitution, Budget& budget) {
  return Expander(substitution, budget).expand_document(root);
}

}  // namespace fire3dv::convert::xacro
