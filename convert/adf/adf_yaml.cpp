#include "convert/adf/adf_yaml.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "convert/description_files.h"
#include "convert/model.h"
#include "renderer/scene/files.h"

namespace fire3dv::convert {

namespace {

constexpr uint64_t kMaxFileBytes = uint64_t{8} << 20;
constexpr size_t kMaxWarnings = 200, kMaxFields = 200;

}  // namespace

void AdfReport::warn(std::string sentence) {
  if (!said_.emplace(sentence, true).second) return;
  if (said_.size() > kMaxWarnings) {
    ++left_out_;
    return;
  }
  model_.warnings.push_back(std::move(sentence));
}

void AdfReport::finish() {
  if (!unknown_.empty()) {
    std::string sentence = "unknown fields are ignored: ";
    size_t listed = 0;
    for (const auto& [name, location] : unknown_) {
      if (listed == 30) {
        sentence += " and " + std::to_string(unknown_.size() - listed) + " more";
        break;
      }
      sentence += (listed++ ? ", " : "") + quote(name) + " (" + location + ")";
    }
    model_.warnings.push_back(std::move(sentence));
  }
  if (left_out_ > 0) model_.warnings.push_back(std::to_string(left_out_) + " more warnings of such kinds");
}

AdfValue::AdfValue(YAML::Node node, std::string file, AdfReport& report)
    : node_(std::move(node)), file_(std::move(file)), report_(&report) {}

AdfValue AdfValue::operator[](std::string_view key) const {
  AdfValue value;
  value.file_ = file_;
  value.report_ = report_;
  value.name_ = key;
  if (!is_map()) return value;
  size_t left = kMaxFields;
  for (const auto& entry : node_) {
    if (left-- == 0) break;
    if (!entry.first.IsScalar() || entry.first.Scalar() != key) continue;
    value.node_.reset(entry.second);
    break;
  }
  return value;
}

std::vector<AdfValue> AdfValue::items(size_t most) const {
  std::vector<AdfValue> items;
  if (!node_.IsDefined() || !node_.IsSequence()) return items;
  for (const auto& item : node_) {
    if (items.size() == most) break;
    items.emplace_back(item, file_, *report_);
    items.back().name_ = name_;
  }
  return items;
}

std::string AdfValue::location() const {
  const int line = node_.IsDefined() ? node_.Mark().line : -1;
  return line < 0 ? file_ : file_ + ":" + std::to_string(line + 1);
}

void AdfValue::warn(const std::string& what) const {
  if (report_) report_->warn(location() + ": " + (name_.empty() ? "" : quote(name_) + " ") + what);
}

double AdfValue::number(double otherwise) const {
  if (!is_defined()) return otherwise;
  double value = 0;
  if (node_.IsScalar() && YAML::convert<double>::decode(node_, value) && std::isfinite(value)) return value;
  warn("is not a number; taken as " + std::to_string(otherwise));
  return otherwise;
}

bool AdfValue::flag(bool otherwise) const {
  if (!is_defined()) return otherwise;
  bool value = false;
  if (node_.IsScalar() && YAML::convert<bool>::decode(node_, value)) return value;
  warn(std::string("is neither true nor false; taken as ") + (otherwise ? "true" : "false"));
  return otherwise;
}

std::string AdfValue::text(const std::string& otherwise) const {
  if (!is_defined()) return otherwise;
  if (node_.IsScalar()) return node_.Scalar();
  warn("is not text");
  return otherwise;
}

glm::dvec3 AdfValue::vector(const glm::dvec3& otherwise, std::string_view keys) const {
  if (!is_defined()) return otherwise;
  if (!is_map()) {
    warn("has no " + std::string(keys.substr(0, 1)) + ", " + std::string(keys.substr(1, 1)) + " and " +
         std::string(keys.substr(2, 1)));
    return otherwise;
  }
  glm::dvec3 value(0);
  for (int i = 0; i < 3; ++i) {
    const AdfValue part = (*this)[keys.substr(static_cast<size_t>(i), 1)];
    if (!part.is_defined()) warn("has no " + std::string(keys.substr(static_cast<size_t>(i), 1)));
    value[i] = part.number(0);
  }
  return value;
}

Result<AdfFile> AdfFile::read(const std::filesystem::path& file, AdfReport& report) {
  const std::string name = quote(file.string());
  if (Result<std::filesystem::path> found = regular_file(file); !found) return found.error();
  Result<FileBytes> bytes = read_file(file, kMaxFileBytes);
  if (!bytes) return bytes.error();
  AdfFile read;
  read.path_ = file;
  read.report_ = &report;
  try {
    read.root_.reset(YAML::Load(std::string(reinterpret_cast<const char*>(bytes->data.get()), bytes->size)));
  } catch (const YAML::Exception& fault) {
    const std::string line = fault.mark.is_null() ? "" : ":" + std::to_string(fault.mark.line + 1);
    return Error{file.string() + line + ": cannot be read as YAML: " + sanitize_text(fault.msg, 200)};
  }
  if (!read.root_.IsMap()) {
    return Error{name +
                 " is no AMBF description: it has no fields such as \"bodies\", \"multibody configs\" or "
                 "\"environment\""};
  }
  for (const auto& entry : read.root_) {
    if (!entry.first.IsScalar()) continue;
    const auto [known, is_new] = read.index_.try_emplace(entry.first.Scalar(), entry.second);
    if (!is_new) {
      report.warn(file.string() + ":" + std::to_string(entry.first.Mark().line + 1) + ": " +
                  quote(known->first) + " is defined twice; the first one applies, as in AMBF");
    }
  }
  return read;
}

AdfValue AdfFile::operator[](std::string_view key) const {
  const auto found = index_.find(std::string(key));
  AdfValue value(found == index_.end() ? YAML::Node(YAML::NodeType::Undefined) : found->second,
                 path_.string(), *report_);
  value.name_ = key;
  return value;
}

std::vector<AdfFile::Block> AdfFile::blocks(std::string_view list) const {
  std::vector<Block> blocks;
  const AdfValue names = (*this)[list];
  if (names.is_defined() && !names.node_.IsSequence()) names.warn("is not a list");
  for (const AdfValue& item : names.items()) {
    const std::string id = item.text();
    if (id.empty()) continue;
    AdfValue block = (*this)[id];
    if (!block.is_map()) {
      item.warn("lists " + quote(id) + ", which the file does not describe");
      continue;
    }
    if (block.node_.size() > kMaxFields)
      block.warn("has more than " + std::to_string(kMaxFields) + " fields");
    blocks.push_back({id, std::move(block)});
  }
  return blocks;
}

void AdfFile::note_unknown_fields() const {
  for (const auto& [key, node] : index_) {
    // Maps are blocks, and lists and scalars are mostly anchors. Without lists of blocks to compare, only
    // scalars count as possible typos.
    if (node.IsScalar() && !is_adf_field(key))
      report_->unknown_field(sanitize_text(key, 60), AdfValue(node, path_.string(), *report_).location());
  }
}

void AdfFile::note_unknown_fields(const AdfValue& block) const {
  if (!block.is_map()) return;
  size_t left = kMaxFields;
  for (const auto& entry : block.node_) {
    if (left-- == 0) break;
    if (entry.first.IsScalar() && !is_adf_field(entry.first.Scalar()))
      report_->unknown_field(sanitize_text(entry.first.Scalar(), 60),
                             AdfValue(entry.first, path_.string(), *report_).location());
  }
}

namespace {

constexpr auto kFields = [] {
  std::array names = std::to_array<std::string_view>({
      // files
      "world config",
      "color config",
      "input devices config",
      "multibody configs",
      "plugins",
      "bodies",
      "soft bodies",
      "ghost objects",
      "vehicles",
      "volumes",
      "joints",
      "sensors",
      "actuators",
      "cameras",
      "lights",
      "high resolution path",
      "low resolution path",
      "namespace",
      "shaders",
      "gravity",
      "ignore inter-collision",
      "joint erp",
      "joint cfm",
      "environment",
      "enclosure",
      "skybox",
      "max iterations",
      "enclosure size",
      // bodies
      "name",
      "mesh",
      "mesh remove duplicates",
      "shape",
      "geometry",
      "compound shape",
      "scale",
      "location",
      "inertial offset",
      "use material",
      "color",
      "color rgba",
      "color components",
      "visible",
      "mass",
      "inertia",
      "collision margin",
      "collision groups",
      "collision mesh",
      "collision mesh type",
      "collision shape",
      "collision offset",
      "collision geometry",
      "compound collision shape",
      "controller",
      "controller output type",
      "damping",
      "friction",
      "restitution",
      "publish frequency",
      "publish children names",
      "publish joint names",
      "publish joint positions",
      "passive",
      "parent",
      "child",
      "config",
      "randomize constraints",
      "bending constraint",
      "cutting",
      "fixed nodes",
      "clusters",
      // cameras and lights
      "look at",
      "up",
      "clipping plane",
      "field view angle",
      "orthographic view width",
      "stereo",
      "controlling devices",
      "monitor",
      "publish image",
      "publish image interval",
      "publish image resolution",
      "publish depth",
      "publish depth interval",
      "publish depth resolution",
      "publish depth noise",
      "preprocessing shaders",
      "depth compute shaders",
      "multipass",
      "mouse control multipliers",
      "direction",
      "spot exponent",
      "shadow quality",
      "cutoff angle",
      "attenuation",
      // joints, as seen by the loader of vehicles and models
      "type",
      "chassis",
      "wheels",
  });
  std::sort(names.begin(), names.end());
  return names;
}();

}  // namespace

bool is_adf_field(std::string_view name) {
  return std::binary_search(kFields.begin(), kFields.end(), name);
}

}  // namespace fire3dv::convert
