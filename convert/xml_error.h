// Error text of an XML document that tinyxml2 refused: line number and reason, without tinyxml2's own codes.
#pragma once

#include <tinyxml2.h>

#include <string>

namespace fire3dv::convert {

inline std::string xml_error(const tinyxml2::XMLDocument& document) {
  std::string reason = document.ErrorName();  // for example XML_ERROR_MISMATCHED_ELEMENT
  const std::string prefix = "XML_ERROR_";
  if (reason.starts_with(prefix)) reason.erase(0, prefix.size());
  for (char& c : reason) c = c == '_' ? ' ' : static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  const std::string text = document.ErrorStr();  // format: "Error=NAME ErrorID=N (0xN) Line number=N:
                                                 // DETAILS"
  const size_t details = text.find(": ", text.find("Line number="));
  return "line " + std::to_string(document.ErrorLineNum()) + ": " + reason +
         (details == std::string::npos ? "" : " (" + text.substr(details + 2) + ")");
}

}  // namespace fire3dv::convert
