#include "convert/mesh/mtl.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <optional>

#include "base/numbers.h"
#include "base/text.h"
#include "base/words.h"
#include "convert/model.h"

namespace fire3dv::convert {
namespace {

constexpr size_t kMaxMtlMaterials = 100'000;
// The first word of `rest`, which is cut off with the blanks behind it.
std::string_view take_word(std::string_view& rest) {
  const std::string_view word = next_word(rest);
  rest = trimmed(rest);
  return word;
}

std::optional<float> finite_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const std::optional<float> value = parse_number<float>(word);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

// Up to three numbers at the start of `rest`; a single one counts for all three.
std::optional<glm::vec3> take_color(std::string_view rest) {
  glm::vec3 color(0);
  for (int i = 0; i < 3; ++i) {
    const std::optional<float> value = finite_number(take_word(rest));
    if (!value && i == 1) return glm::vec3(color.r);
    if (!value) return std::nullopt;
    color[i] = *value;
  }
  return color;
}

// Options of a texture in front of its name.
struct MapOptions {
  glm::vec3 scale{1}, origin{0};
  bool is_clamped = false;
  std::string channel;               // -imfchan: r, g, b, m, l or z
  std::vector<std::string> ignored;  // options that change the image
};

// The numbers at the start of `rest`, at most three. The last word is the name of the image, never a number.
glm::vec3 take_numbers(std::string_view& rest, glm::vec3 values) {
  for (int i = 0; i < 3; ++i) {
    std::string_view after = rest;
    const std::optional<float> value = finite_number(take_word(after));
    if (!value || after.empty()) break;
    values[i] = *value;
    rest = after;
  }
  return values;
}

MapOptions take_options(std::string_view& rest) {
  MapOptions options;
  while (rest.starts_with('-')) {
    std::string_view after = rest;
    const std::string option = lower_case(std::string(take_word(after)));
    if (option == "-s" || option == "-o" || option == "-t") {
      glm::vec3& to = option == "-s" ? options.scale : options.origin;
      const glm::vec3 values = take_numbers(after, option == "-s" ? glm::vec3(1) : glm::vec3(0));
      if (option != "-t")
        to = values;
      else if (values != glm::vec3(0))
        options.ignored.push_back(option);
    } else if (option == "-mm") {
      if (take_numbers(after, {0, 1, 0}) != glm::vec3(0, 1, 0)) options.ignored.push_back(option);
    } else if (option == "-clamp") {
      options.is_clamped = lower_case(std::string(take_word(after))) == "on";
    } else if (option == "-imfchan") {
      options.channel = lower_case(std::string(take_word(after)));
    } else if (option == "-cc") {
      if (lower_case(std::string(take_word(after))) != "off") options.ignored.push_back(option);
    } else if (option == "-bm" || option == "-blendu" || option == "-blendv" || option == "-boost" ||
               option == "-texres" || option == "-type") {
      take_word(after);  // filters, and the height of bumps
    } else {
      break;  // a name that starts with a minus sign
    }
    rest = after;
  }
  return options;
}

std::string unquoted(std::string_view name) {
  if (name.size() >= 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
  return std::string(name);
}

// The letters of -imfchan; z is the depth.
std::optional<OpacityChannel> channel_of(const std::string& letter) {
  static const std::map<std::string, OpacityChannel> kChannels = {
      {"", OpacityChannel::automatic}, {"l", OpacityChannel::brightness}, {"m", OpacityChannel::opacity},
      {"r", OpacityChannel::red},      {"g", OpacityChannel::green},      {"b", OpacityChannel::blue}};
  const auto known = kChannels.find(letter);
  return known == kChannels.end() ? std::nullopt : std::optional(known->second);
}

ImagePlacement placement_of(const MapOptions& options) {
  ImagePlacement placement;
  placement.scale = glm::vec2(options.scale);
  // MTL counts v upwards.
  placement.offset = {options.origin.x, 1 - options.scale.y - options.origin.y};
  if (options.is_clamped) placement.wrap_u = placement.wrap_v = Wrap::clamp;
  return placement;
}

}  // namespace

void MtlMaterials::add(std::string_view text, const std::string& folder) {
  folder_ = folder;
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  Entry* current = nullptr;
  std::string joined;
  while (!text.empty()) {
    const size_t end = std::min(text.find_first_of("\n\r"), text.size());
    std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + (text.substr(end).starts_with("\r\n") ? 2 : 1), text.size()));
    if (line.ends_with('\\')) {  // continued on the next line
      joined += line.substr(0, line.size() - 1);
      joined += ' ';
      continue;
    }
    if (!joined.empty()) line = trimmed(joined += line);
    const std::string keyword = lower_case(std::string(take_word(line)));
    if (keyword == "newmtl") {
      if (entries_.size() >= kMaxMtlMaterials) return;
      current = &entries_[std::string(line)];
      current->material.name = sanitize_text(line, 200);
    } else if (current && !keyword.starts_with('#')) {
      set(keyword, line, *current);
    }
    joined.clear();
  }
}

void MtlMaterials::set(const std::string& keyword, std::string_view rest, Entry& to) {
  ImportedMaterial& m = to.material;
  if (keyword == "kd" || keyword == "ks" || keyword == "ke") {
    const std::optional<glm::vec3> color = take_color(rest);
    if (!color) return;
    if (keyword == "kd") {
      m.diffuse = *color;
      to.has_diffuse = true;
    } else if (keyword == "ke") {
      m.emission = *color;
    } else {
      to.has_specular = *color != glm::vec3(0);
    }
    return;
  }
  if (keyword.starts_with("map_") || keyword == "bump" || keyword == "norm" || keyword == "refl" ||
      keyword == "disp" || keyword == "decal")
    return set_map(keyword, rest, to);
  const bool is_halo = keyword == "d" && rest.starts_with("-halo");
  if (is_halo) {
    take_word(rest);
    leave_out("d -halo", m.name);
  }
  const std::optional<float> number = finite_number(take_word(rest));
  if (!number) return;
  if (keyword == "d") {
    m.opacity = std::clamp(*number, 0.0f, 1.0f);
    to.has_dissolve = true;
  } else if (keyword == "tr" && !to.has_dissolve) {
    m.opacity = std::clamp(1 - *number, 0.0f, 1.0f);
  } else if (keyword == "ns") {
    to.specular_exponent = std::max(*number, 0.0f);
  } else if (keyword == "pr") {
    m.roughness = std::clamp(*number, 0.0f, 1.0f);
    to.has_roughness = true;
  } else if (keyword == "pm") {
    m.metallic = std::clamp(*number, 0.0f, 1.0f);
  } else if (keyword == "pc" || keyword == "ps" || keyword == "aniso") {
    if (*number != 0)
      leave_out(keyword == "pc"   ? "Pc (clearcoat)"
                : keyword == "ps" ? "Ps (sheen)"
                                  : "aniso (anisotropy)",
                m.name);
  }
}

void MtlMaterials::set_map(const std::string& keyword, std::string_view rest, Entry& to) {
  const MapOptions options = take_options(rest);
  if (rest.empty()) return;
  ImportedMaterial& m = to.material;
  const ImagePlacement placement = placement_of(options);
  const auto take = [&](std::string& name, ImagePlacement& where, bool takes_channel = false) {
    name = unquoted(rest);
    const bool is_relative = !name.starts_with('/') && name.find(':') == std::string::npos;
    if (is_relative && !folder_.empty()) name = folder_ + "/" + name;
    where = placement;
    for (const std::string& option : options.ignored)
      leave_out("the option " + option + " of " + keyword, m.name);
    if (!options.channel.empty() && !takes_channel) leave_out("the option -imfchan of " + keyword, m.name);
  };
  if (keyword == "map_kd") {
    take(m.diffuse_image, m.diffuse_placement);
  } else if (keyword == "map_ke" || keyword == "map_emissive") {
    take(m.emission_image, m.emission_placement);
  } else if (keyword == "norm" || keyword == "map_kn") {
    take(m.normal_image, m.normal_placement);
  } else if (keyword == "map_pr") {
    take(m.roughness_image, m.roughness_placement);
  } else if (keyword == "map_pm") {
    ImagePlacement own;
    take(m.metallic_image, m.roughness_image.empty() ? m.roughness_placement : own);
  } else if (keyword == "bump" || keyword == "map_bump") {
    leave_out("map_Bump (write normal maps as norm)", m.name);
  } else if (keyword == "map_d") {
    const std::optional<OpacityChannel> channel = channel_of(options.channel);
    take(m.opacity_image, m.opacity_placement, channel.has_value());
    m.opacity_channel = channel.value_or(OpacityChannel::automatic);
  } else if (keyword == "map_ks" || keyword == "map_ns" || keyword == "map_ps" || keyword == "map_tr" ||
             keyword == "disp" || keyword == "decal" || keyword == "refl" || keyword == "map_refl") {
    leave_out(keyword, m.name);
  }
}

void MtlMaterials::leave_out(const std::string& what, const std::string& material) {
  Omission& omission = omissions_[what];
  if (omission.count++ == 0) omission.first = material;
}

ImportedMaterial MtlMaterials::material(std::string_view name) const {
  const Entry& entry = entries_.find(name)->second;
  ImportedMaterial m = entry.material;
  // White where the texture is all that is said; else the grey of common readers. Exporters also write a
  // black colour beside a map that is meant to replace it.
  if (!entry.has_diffuse) m.diffuse = glm::vec3(m.diffuse_image.empty() ? 0.6f : 1.0f);
  if (!m.diffuse_image.empty() && m.diffuse == glm::vec3(0)) m.diffuse = glm::vec3(1);
  if (!entry.has_roughness) {
    // The exponent as AMBF's library reads it, as the roughness of an equal highlight.
    const float exponent = std::min(128.0f, 1.28f * 1.28f * entry.specular_exponent);
    m.roughness = entry.has_specular ? std::sqrt(2 / (exponent + 2)) : 1;
  }
  // Exporters write 0, or nothing, beside a map.
  if (!m.roughness_image.empty() && (!entry.has_roughness || m.roughness == 0)) m.roughness = 1;
  return m;
}

std::string MtlMaterials::names() const {
  std::string text;
  for (const auto& [name, entry] : entries_) text += "newmtl " + name + "\nKd 0.6 0.6 0.6\n";
  return text;
}

std::vector<std::string> MtlMaterials::warnings() const {
  std::vector<std::string> lines;
  for (const auto& [what, omission] : omissions_) {
    lines.push_back("material " + quote(omission.first) +
                    (omission.count > 1 ? " and " + std::to_string(omission.count - 1) + " more" : "") +
                    ": " + what + " is not drawn");
  }
  return lines;
}

}  // namespace fire3dv::convert
