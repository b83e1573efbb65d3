// Element tree of a xacro document, with the location of each element for messages.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "convert/xacro/expression/budget.h"

namespace fire3dv::convert::xacro {

// Element, or text if the name is empty. Comments are dropped.
struct Element {
  std::string name;
  std::string text;
  bool is_cdata = false;
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<Element> children;
  std::shared_ptr<const std::string> file;
  int line = 0;

  bool is_text() const { return name.empty(); }
  // Null if there is none.
  const std::string* attribute(const std::string& wanted) const;
  void set(const std::string& attribute, std::string value);
  // "FILE, line N, <NAME>"
  std::string location() const;
};

// Returns the root element. The error names file and line. Checks the text as xml_root() does.
Result<Element> parse_document(const std::filesystem::path& file, const std::string& text);

std::string write_document(const Element& root, Budget& budget);

// Charges a copy of the element.
void charge(const Element& element, Budget& budget);

}  // namespace fire3dv::convert::xacro
