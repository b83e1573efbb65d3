#include "convert/xacro/xacro.h"

#include <cstddef>
#include <utility>

#include "convert/xacro/document.h"
#include "convert/xacro/expander.h"
#include "convert/xacro/expression/budget.h"
#include "convert/xacro/substitution.h"

namespace fire3dv::convert {
namespace {

// ur5.urdf.xacro -> ur5.expanded.urdf: never the name of the file itself, which `>` would empty first.
std::string expanded_name(const std::filesystem::path& file) {
  std::filesystem::path name = file.filename();
  for (const char* extension : {".xacro", ".urdf", ".xml"})
    if (name.extension() == extension) name.replace_extension();
  return name.string() + ".expanded.urdf";
}

}  // namespace

bool has_xacro_element(std::string_view text) {
  const auto behind = [&](size_t at, std::string_view closing) {
    const size_t end = text.find(closing, at);
    return end == std::string_view::npos ? end : end + closing.size();
  };
  for (size_t at = text.find('<'); at != std::string_view::npos; at = text.find('<', at)) {
    const std::string_view rest = text.substr(at);
    if (rest.starts_with("<xacro:")) return true;
    at = rest.starts_with("<!--")        ? behind(at + 4, "-->")
         : rest.starts_with("<![CDATA[") ? behind(at, "]]>")
                                         : at + 1;
  }
  return false;
}

Result<ExpandedXacro> expand_xacro(const std::filesystem::path& file, const std::string& text,
                                   const std::map<std::string, std::string>& arguments, UrdfFiles& files,
                                   Sources& sources) {
  const Result<xacro::Element> root = xacro::parse_document(file, text);
  if (!root) return root.error();
  xacro::Budget budget;
  xacro::Substitution substitution(file, arguments, files, sources, budget);
  try {
    const xacro::Element expanded = xacro::expand(*root, substitution, budget);
    return ExpandedXacro{xacro::write_document(expanded, budget), substitution.take_warnings()};
  } catch (const xacro::Failure& failure) {
    std::string message = failure.message();
    if (failure.kind() == xacro::Failure::Kind::unsupported)
      message += "; expand the file with the program xacro: xacro " + file.filename().string() + " > " +
                 expanded_name(file) + ", or name the program with --xacro PROGRAM";
    return Error{std::move(message)};
  }
}

}  // namespace fire3dv::convert
