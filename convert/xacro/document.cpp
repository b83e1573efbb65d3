#include "convert/xacro/document.h"

#include <tinyxml2.h>

#include <algorithm>
#include <string_view>

#include "base/text.h"
#include "convert/description_files.h"
#include "convert/xml_error.h"

namespace fire3dv::convert::xacro {
namespace {

// White space in attributes is read as blanks (XML 1.0, 3.3.3); tinyxml2 keeps it.
std::string normalised(std::string value) {
  std::replace_if(
      value.begin(), value.end(), [](char c) { return c == '\n' || c == '\t' || c == '\r'; }, ' ');
  return value;
}

// The depth is bounded by xml_root().
Element convert(const tinyxml2::XMLElement& from, const std::shared_ptr<const std::string>& file) {
  Element to;
  to.name = from.Name();
  to.file = file;
  to.line = from.GetLineNum();
  for (const tinyxml2::XMLAttribute* a = from.FirstAttribute(); a; a = a->Next())
    to.attributes.emplace_back(a->Name(), normalised(a->Value()));
  for (const tinyxml2::XMLNode* child = from.FirstChild(); child; child = child->NextSibling()) {
    if (const tinyxml2::XMLElement* element = child->ToElement()) {
      to.children.push_back(convert(*element, file));
    } else if (const tinyxml2::XMLText* text = child->ToText()) {
      Element made;
      made.text = text->Value();
      made.is_cdata = text->CData();
      made.file = file;
      made.line = text->GetLineNum();
      to.children.push_back(std::move(made));
    }
  }
  return to;
}

void append_escaped(std::string_view text, bool is_attribute, std::string& out) {
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"' && is_attribute)
      out += "&quot;";
    else
      out += c;
  }
}

void write(const Element& element, size_t level, std::string& out) {
  if (out.size() > Budget::kMaxOutputBytes)
    throw Failure("the expanded text has more than " + std::to_string(Budget::kMaxOutputBytes >> 20) +
                  " MiB");
  if (element.is_text()) {
    if (element.is_cdata && element.text.find("]]>") == std::string::npos)
      out += "<![CDATA[" + element.text + "]]>";
    else
      append_escaped(element.text, false, out);
    return;
  }
  out += "<" + element.name;
  for (const auto& [name, value] : element.attributes) {
    out += " " + name + "=\"";
    append_escaped(value, true, out);
    out += '"';
  }
  if (element.children.empty()) {
    out += "/>";
    return;
  }
  out += '>';
  // Text makes white space significant.
  const bool has_text =
      std::any_of(element.children.begin(), element.children.end(), [](const Element& child) {
        return child.is_text() && child.text.find_first_not_of(" \t\r\n") != std::string::npos;
      });
  for (const Element& child : element.children) {
    if (!has_text && child.is_text()) continue;
    if (!has_text) out += "\n" + std::string(2 * (level + 1), ' ');
    write(child, level + 1, out);
  }
  if (!has_text) out += "\n" + std::string(2 * level, ' ');
  out += "</" + element.name + ">";
}

}  // namespace

const std::string* Element::attribute(const std::string& wanted) const {
  for (const auto& [known, value] : attributes)
    if (known == wanted) return &value;
  return nullptr;
}

void Element::set(const std::string& attribute, std::string value) {
  for (auto& [known, old] : attributes) {
    if (known != attribute) continue;
    old = std::move(value);
    return;
  }
  attributes.emplace_back(attribute, std::move(value));
}

std::string Element::location() const {
  return quote(file ? *file : "") + ", line " + std::to_string(line) + (is_text() ? "" : ", <" + name + ">");
}

Result<Element> parse_document(const std::filesystem::path& file, const std::string& text) {
  const std::string name = quote(file.string());
  const Result<std::string> root = xml_root(text);
  if (!root) return Error{name + ", " + root.error().message};
  tinyxml2::XMLDocument document;
  if (document.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS)
    return Error{name + ", " + xml_error(document)};
  if (!document.RootElement()) return Error{name + " has no element"};
  return convert(*document.RootElement(), std::make_shared<const std::string>(file.string()));
}

std::string write_document(const Element& root, Budget& budget) {
  std::string out = "<?xml version=\"1.0\"?>\n";
  budget.step();
  write(root, 0, out);
  return out + "\n";
}

void charge(const Element& element, Budget& budget) {
  budget.step();
  size_t bytes = sizeof(Element) + element.text.size() + element.name.size();
  for (const auto& [name, value] : element.attributes) bytes += name.size() + value.size() + 64;
  budget.bytes(bytes);
  for (const Element& child : element.children) charge(child, budget);
}

}  // namespace fire3dv::convert::xacro
