#include "convert/sdf/files/sdf_documents.h"

#include <sys/mman.h>
#include <tinyxml2.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <optional>
#include <system_error>
#include <utility>

#include "base/words.h"
#include "convert/description_files.h"
#include "convert/sdf/files/sdf_include_text.h"
#include "convert/sdf/files/sdf_version.h"
#include "convert/xml_error.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {
namespace {

namespace fs = std::filesystem;
constexpr size_t kMaxDocuments = 500;  // each holds a descriptor
constexpr size_t kMaxLevels = 30;      // of includes in includes
constexpr size_t kMaxElements = 200'000;

// Elements in the order of the file, with those of plugins, whose contents libsdformat copies.
struct Includes {
  std::vector<const tinyxml2::XMLElement*> all;
  std::vector<bool> are_read;
  size_t elements = 0;
};

void collect(const tinyxml2::XMLElement& element, bool is_read,
             Includes& to) {  // xml_root() limits the depth
  ++to.elements;
  const std::string_view name = element.Name();
  if (name == "include") {
    to.all.push_back(&element);
    to.are_read.push_back(is_read);
    is_read = false;  // an include has no includes
  }
  if (name == "plugin") is_read = false;
  for (const tinyxml2::XMLElement* child = element.FirstChildElement(); child;
       child = child->NextSiblingElement())
    collect(*child, is_read, to);
}

// libsdformat dereferences the texts of these elements, and what it knows of their attributes.
std::optional<std::string> why_invalid(const tinyxml2::XMLElement& include) {
  const tinyxml2::XMLElement* uri = include.FirstChildElement("uri");
  if (!uri || !uri->GetText()) return "it has no <uri>";
  for (const char* name : {"name", "static", "placement_frame"}) {
    const tinyxml2::XMLElement* child = include.FirstChildElement(name);
    if (child && !child->GetText()) return "its <" + std::string(name) + "> is empty";
  }
  constexpr std::string_view kOfPose[] = {"relative_to", "degrees", "rotation_format", "frame"};
  for (const char* name : {"uri", "name", "static", "placement_frame", "pose"}) {
    for (const tinyxml2::XMLElement* child = include.FirstChildElement(name); child;
         child = child->NextSiblingElement(name))
      for (const tinyxml2::XMLAttribute* each = child->FirstAttribute(); each; each = each->Next())
        if (name != std::string_view("pose") ||
            std::find(std::begin(kOfPose), std::end(kOfPose), each->Name()) == std::end(kOfPose))
          return "its <" + std::string(name) + "> has the unknown attribute " + quote(each->Name());
  }
  return std::nullopt;
}

}  // namespace

SdfDocuments::~SdfDocuments() {
  for (const int descriptor : descriptors_) ::close(descriptor);
}

Result<std::string> SdfDocuments::open(const fs::path& file) {
  const Result<const Document*> document = read(file, 0);
  if (!document) return document.error();
  return (*document)->copy;
}

Result<const SdfDocuments::Document*> SdfDocuments::read(const fs::path& file, size_t level) {
  const std::string name = quote(file.string());
  sources_.add(file);
  const Result<fs::path> resolved = regular_file(file);
  if (!resolved) return resolved.error();
  if (const auto known = documents_.find(*resolved); known != documents_.end()) {
    if (known->second.is_open)
      return Error{name + " includes itself, over others: remove one of the includes"};
    return &known->second;
  }
  if (documents_.size() >= kMaxDocuments)
    return Error{name + " is left out: there are more than " + std::to_string(kMaxDocuments) +
                 " included files"};
  if (level > kMaxLevels)
    return Error{name + " is left out: more than " + std::to_string(kMaxLevels) +
                 " files include each other"};
  Result<std::string> text = read_text(file);
  if (!text) return text.error();
  Document& document = documents_[*resolved];
  document.file = file;
  document.is_open = true;
  Result<std::string> prepared = prepare(document, std::move(*text), level);
  document.is_open = false;
  Result<std::string> copy = prepared ? copy_of(*prepared) : Result<std::string>(prepared.error());
  if (!copy) {
    documents_.erase(*resolved);
    return copy.error();
  }
  document.copy = std::move(*copy);
  return &document;
}

// Returns the text for libsdformat, with the same lines.
Result<std::string> SdfDocuments::prepare(Document& document, std::string text, size_t level) {
  const std::string name = quote(document.file.string());
  const Result<std::string> root_name = xml_root(text);
  if (!root_name) return Error{name + ": " + root_name.error().message};
  if (*root_name == "robot")
    return Error{name +
                 " is URDF, which SDF files of libsdformat alone include: convert it with \"gz sdf -p\""};
  if (*root_name != "sdf") return Error{name + " is no SDF: its root element is <" + *root_name + ">"};
  tinyxml2::XMLDocument xml;
  if (xml.Parse(text.c_str()) != tinyxml2::XML_SUCCESS) return Error{name + ", " + xml_error(xml)};
  const char* version = xml.RootElement()->Attribute("version");
  const std::optional<unsigned> minor = minor_sdf_version(version ? version : "");
  if (!minor)
    return Error{name + ": <sdf> has " +
                 (version ? "the unknown version " + quote(version) : std::string("no version")) +
                 ": write <sdf version=\"1.9\">, or the version that the file is written for"};
  Includes includes;
  collect(*xml.RootElement(), true, includes);
  document.elements = includes.elements;
  std::vector<std::optional<std::string>> replacements;  // new URI; "" removes the include; none keeps it
  for (size_t i = 0; i < includes.all.size(); ++i) {
    if (!includes.are_read[i]) {
      replacements.emplace_back();
      continue;
    }
    const tinyxml2::XMLElement& include = *includes.all[i];
    const std::string location = document.file.string() + ", line " + std::to_string(include.GetLineNum()) +
                                 ": <include> is left out: ";
    if (const std::optional<std::string> why = why_invalid(include)) {
      warnings_.push_back(location + *why);
      replacements.emplace_back("");
      continue;
    }
    const Result<const Document*> other =
        included(std::string(trimmed(include.FirstChildElement("uri")->GetText())), document.file, level);
    if (!other) {
      warnings_.push_back(location + other.error().message);
      replacements.emplace_back("");
      continue;
    }
    document.elements += (*other)->elements;
    if (document.elements > kMaxElements)
      return Error{name + " has, with what it includes, more than " + std::to_string(kMaxElements) +
                   " elements: split it"};
    replacements.emplace_back((*other)->copy);
  }
  if (document.elements > kMaxElements)
    return Error{name + " has more than " + std::to_string(kMaxElements) + " elements: split it"};
  if (*minor > kNewestSdfMinorVersion) {
    warnings_.push_back(document.file.string() + ": SDF " + version + " is read as SDF 1." +
                        std::to_string(kNewestSdfMinorVersion) +
                        ", the newest of libsdformat 12; newer elements may be left out");
    text = with_sdf_version(std::move(text), "1." + std::to_string(kNewestSdfMinorVersion));
  }
  Result<std::string> made = with_include_uris(text, replacements);
  if (!made) return Error{name + ": " + made.error().message};
  return made;
}

Result<const SdfDocuments::Document*> SdfDocuments::included(const std::string& uri, const fs::path& from,
                                                             size_t level) {
  Result<fs::path> found = files_.resolve(uri, from);
  if (!found) return found.error();
  std::error_code error;
  if (fs::is_directory(*found, error)) {
    found = sdf_of_model_folder(*found, kNewestSdfMinorVersion, sources_);
    if (!found) return found.error();
  }
  return read(*found, level + 1);
}

Result<std::string> SdfDocuments::copy_of(std::string_view text) {
  const int descriptor = ::memfd_create("sdf", MFD_CLOEXEC);
  if (descriptor < 0)
    return Error{std::string("no memory for a copy of an SDF file: ") + std::strerror(errno)};
  descriptors_.push_back(descriptor);
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0)
      return Error{std::string("no memory for a copy of an SDF file: ") + std::strerror(errno)};
    text.remove_prefix(static_cast<size_t>(written));
  }
  return "/proc/self/fd/" + std::to_string(descriptor);
}

fs::path SdfDocuments::original(const std::string& copy) const {
  for (const auto& [resolved, document] : documents_)
    if (!document.copy.empty() && document.copy == copy) return document.file;
  return copy;
}

std::string SdfDocuments::with_originals(std::string message) const {
  constexpr std::string_view kCopy = "/proc/self/fd/";
  for (size_t at = message.find(kCopy); at != std::string::npos; at = message.find(kCopy, at)) {
    const size_t end = std::min(message.find_first_not_of("0123456789", at + kCopy.size()), message.size());
    const std::string file = original(message.substr(at, end - at)).string();
    message.replace(at, end - at, file);
    at += file.starts_with(kCopy) ? kCopy.size() : file.size();
  }
  return message;
}

}  // namespace fire3dv::convert
