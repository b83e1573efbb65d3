#include "programs/inspect/recorded_edits.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <variant>

#include "base/plural.h"
#include "protocol/wire/check.h"

namespace fire3dv::inspect {
namespace {

std::string kind_name(uint8_t kind) {
  if (kind < wire::kMarkerKindCount) return wire::marker_kind_name(static_cast<wire::MarkerKind>(kind));
  return "kind " + std::to_string(kind);
}

// Elements of a marker, as users count them.
uint64_t elements_of(const wire::Marker& marker) {
  const uint64_t positions = marker.positions.size();
  switch (marker.kind) {
    case wire::MarkerKind::lines:
    case wire::MarkerKind::arrows:
      return positions / 2;
    case wire::MarkerKind::triangles:
      return positions / 3;
    default:
      return positions;
  }
}

}  // namespace

std::string scalar_text(const stream::ScalarHistory& scalars, const char* indent) {
  std::string text;
  for (const auto& [name, group] : scalars.groups())
    for (size_t i = 0; i < group.statistics().size(); ++i) {
      const stream::ScalarStatistics& statistics = group.statistics()[i];
      text += indent + wire::printable(name + "/" + group.declared().names[i], 128);
      if (const std::string& unit = group.declared().units[i]; !unit.empty()) text += " [" + unit + "]";
      text += ": " + counted(statistics.count, "value");
      if (statistics.count != 0) {
        char numbers[128];
        std::snprintf(numbers, sizeof numbers, ", min %.6g, max %.6g, last %.6g", statistics.min,
                      statistics.max, statistics.last);
        text += numbers;
      }
      text += '\n';
    }
  return text;
}

nlohmann::json scalar_json(const stream::ScalarHistory& scalars) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& [name, group] : scalars.groups())
    for (size_t i = 0; i < group.statistics().size(); ++i) {
      const stream::ScalarStatistics& statistics = group.statistics()[i];
      list.push_back({{"group", name},
                      {"name", group.declared().names[i]},
                      {"unit", group.declared().units[i]},
                      {"count", statistics.count},
                      {"min", statistics.min},  // NaN is null
                      {"max", statistics.max},
                      {"last", statistics.last}});
    }
  return list;
}

void RecordedEdits::take(const std::string& name, const wire::SceneEdit& edit) {
  const bool is_marker = edit.property == wire::Property::marker;
  if (!is_marker && !wire::is_scalar(edit.property)) return;
  StreamEdits& stream = streams_[name];
  if (stream.epoch != edit.epoch) {
    stream.epoch = edit.epoch;
    stream.version = 0;
    stream.scalars = stream::ScalarHistory(budget_, stream::ScalarHistory::Keep::statistics);
  }
  if (edit.version <= stream.version) return;
  stream.version = edit.version;
  if (!is_marker) {
    (void)stream.scalars.apply(edit);
    return;
  }
  const auto known = stream.markers.find(edit.node);
  const auto* marker = std::get_if<wire::Marker>(&edit.value);
  if (!marker) {
    if (known != stream.markers.end()) known->second.is_cleared = true;
    return;
  }
  if (known == stream.markers.end() && marker_count_ == kMaxMarkers) {
    ++stream.further_markers;
    return;
  }
  if (known == stream.markers.end()) ++marker_count_;
  MarkerSeen& seen = stream.markers[edit.node];
  seen.kind = static_cast<uint8_t>(marker->kind);
  seen.elements = elements_of(*marker);
  ++seen.values;
  seen.is_cleared = false;
}

std::string RecordedEdits::text(const std::string& name) const {
  const auto stream = streams_.find(name);
  if (stream == streams_.end()) return {};
  std::string text = scalar_text(stream->second.scalars, "    ");
  size_t listed = 0;
  for (const auto& [marker, seen] : stream->second.markers) {
    if (listed++ == kMaxListed) break;
    text += "    marker " + wire::printable(marker, 128) + ": " + kind_name(seen.kind) + ", " +
            counted(seen.elements, "element") + ", set " + counted(seen.values, "time") +
            (seen.is_cleared ? ", cleared\n" : "\n");
  }
  if (stream->second.markers.size() > kMaxListed)
    text += "    and " + counted(stream->second.markers.size() - kMaxListed, "more marker") + '\n';
  if (stream->second.further_markers != 0)
    text += "    and " + counted(stream->second.further_markers, "value") + " of further markers\n";
  return text;
}

void RecordedEdits::add_json(const std::string& name, nlohmann::json& to) const {
  nlohmann::json markers = nlohmann::json::array(), scalars = nlohmann::json::array();
  if (const auto stream = streams_.find(name); stream != streams_.end()) {
    scalars = scalar_json(stream->second.scalars);
    for (const auto& [marker, seen] : stream->second.markers)
      markers.push_back({{"name", marker},
                         {"kind", kind_name(seen.kind)},
                         {"elements", seen.elements},
                         {"values", seen.values},
                         {"cleared", seen.is_cleared}});
  }
  to["scalars"] = std::move(scalars);
  to["markers"] = std::move(markers);
}

}  // namespace fire3dv::inspect
