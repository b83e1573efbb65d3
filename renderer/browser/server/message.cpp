#include "renderer/browser/server/message.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

namespace fire3dv::serve {
namespace {

using Kind = ClientMessage::Kind;
using Json = nlohmann::json;

constexpr std::array<std::pair<std::string_view, Kind>, 26> kKinds{{
    {"hello", Kind::hello},     {"size", Kind::size},       {"shown", Kind::shown},
    {"orbit", Kind::orbit},     {"pan", Kind::pan},         {"zoom", Kind::zoom},
    {"fly", Kind::fly},         {"frame", Kind::frame},     {"codec", Kind::codec},
    {"camera", Kind::camera},   {"pick", Kind::pick},       {"inspect", Kind::inspect},
    {"view", Kind::view},       {"plot", Kind::plot},       {"plotted", Kind::plotted},
    {"hide", Kind::hide},       {"isolate", Kind::isolate}, {"show_all", Kind::show_all},
    {"play", Kind::play},       {"step", Kind::step},       {"seek", Kind::seek},
    {"joint", Kind::joint},     {"posture", Kind::posture}, {"setting", Kind::setting},
    {"quality", Kind::quality}, {"input", Kind::input},
}};

// Reader of the fields of one message; remembers the first fault.
class Fields {
 public:
  explicit Fields(const Json& object) : object_(object) {}

  void number(const char* name, double low, double high, double& value) {
    const auto at = object_.find(name);
    if (at == object_.end() || !at->is_number()) return fail(name, "must be a number");
    const double given = at->get<double>();
    if (!(given >= low && given <= high))
      return fail(name, "must be from " + std::to_string(low) + " to " + std::to_string(high));
    value = given;
  }
  template <typename Integer>
  void integer(const char* name, uint64_t low, uint64_t high, Integer& value) {
    const auto at = object_.find(name);
    if (at == object_.end() || !at->is_number_unsigned()) return fail(name, "must be a whole number");
    const auto given = at->get<uint64_t>();
    if (given < low || given > high)
      return fail(name, "must be from " + std::to_string(low) + " to " + std::to_string(high));
    value = static_cast<Integer>(given);
  }
  void optional(const char* name, std::optional<uint32_t>& value) {
    const auto at = object_.find(name);
    if (at == object_.end() || at->is_null()) return;
    integer(name, 0, UINT32_MAX - 1, value.emplace());
  }
  void flag(const char* name, bool& value) {
    const auto at = object_.find(name);
    if (at == object_.end() || !at->is_boolean()) return fail(name, "must be true or false");
    value = at->get<bool>();
  }
  void optional_flag(const char* name, bool& value) {
    if (object_.contains(name)) flag(name, value);
  }
  void text(const char* name, size_t max_bytes, std::string& value) {
    const auto at = object_.find(name);
    if (at == object_.end() || !at->is_string() || at->get_ref<const std::string&>().size() > max_bytes)
      return fail(name, "must be a text of at most " + std::to_string(max_bytes) + " bytes");
    value = at->get<std::string>();
  }
  // Index among these names.
  template <size_t count>
  void name_of(const char* name, const std::array<std::string_view, count>& names, size_t& value) {
    std::string given;
    text(name, 16, given);
    const auto known = std::ranges::find(names, given);
    if (known == names.end()) return fail(name, "is not known; reload the page");
    value = static_cast<size_t>(known - names.begin());
  }
  template <size_t count>
  void numbers(const char* name, double limit, std::array<double, count>& values) {
    const auto at = object_.find(name);
    if (at == object_.end() || !at->is_array() || at->size() != count)
      return fail(name, "must be a list of " + std::to_string(count) + " numbers");
    for (size_t i = 0; i < count; ++i) {
      const Json& given = (*at)[i];
      if (!given.is_number() || !(std::abs(given.get<double>()) <= limit))
        return fail(name, "must have numbers of at most " + std::to_string(limit));
      values[i] = given.get<double>();
    }
  }
  void indices(const char* name, size_t max_count, std::vector<uint32_t>& values) {
    const auto at = object_.find(name);
    if (at == object_.end() || !at->is_array() || at->size() > max_count)
      return fail(name, "must be a list of at most " + std::to_string(max_count) + " indices");
    for (const Json& given : *at) {
      if (!given.is_number_unsigned() || given.get<uint64_t>() > UINT32_MAX)
        return fail(name, "must have whole numbers");
      values.push_back(given.get<uint32_t>());
    }
  }
  void view(ClientMessage::View& view) {
    constexpr double kMaxMetres = 1e9;
    numbers("position", kMaxMetres, view.position_m);
    numbers("rotation", 1.001, view.world_from_camera);
    double square = 0;
    for (const double part : view.world_from_camera) square += part * part;
    if (!(square > 0.25)) fail("rotation", "must be a unit quaternion");
    number("distance", 1e-9, kMaxMetres, view.focus_distance_m);
    number("fov", 0.01, 3.1, view.vertical_fov_rad);
  }
  // A node, and the scene that it belongs to.
  void node(bool is_required, ClientMessage& message) {
    optional("node", message.node);
    if (message.node) integer("scene", 0, UINT64_MAX, message.scene);
    if (is_required && !message.node) fail("node", "is missing");
  }
  const std::string& fault() const { return fault_; }

 private:
  void fail(const std::string& name, const std::string& why) {
    if (fault_.empty()) fault_ = "\"" + name + "\" " + why;
  }
  const Json& object_;
  std::string fault_;
};

// By number. A page has no drags.
constexpr std::array<std::string_view, 7> kActions{"set", "press", "run", "pause", "step", "reset", "speed"};
static_assert(static_cast<size_t>(wire::InputAction::begin) == kActions.size());

void read_input(Fields& fields, ClientMessage& message) {
  constexpr double kMaxValue = 1e12;
  fields.integer("list", 0, UINT32_MAX, message.number);
  fields.integer("index", 0, UINT32_MAX - 1, message.index.emplace());
  size_t action = 0;
  fields.name_of("action", kActions, action);
  message.action = static_cast<wire::InputAction>(action);
  fields.number("value", -kMaxValue, kMaxValue, message.x);
  fields.text("text", wire::kMaxInputTextBytes, message.value);
}

void read_fields(Fields& fields, ClientMessage& message) {
  constexpr double kMaxTurn = 100, kMaxMove = 1000, kMaxPosition = 1e6;
  switch (message.kind) {
    case Kind::hello:
      return fields.text("token", 128, message.token);
    case Kind::size:
      fields.integer("width", 1, kMaxViewSide, message.width);
      return fields.integer("height", 1, kMaxViewSide, message.height);
    case Kind::shown:
      return fields.integer("image", 1, UINT32_MAX, message.number);
    case Kind::orbit:
      fields.number("yaw", -kMaxTurn, kMaxTurn, message.x);
      return fields.number("pitch", -kMaxTurn, kMaxTurn, message.y);
    case Kind::pan:
      fields.number("right", -kMaxMove, kMaxMove, message.x);
      return fields.number("up", -kMaxMove, kMaxMove, message.y);
    case Kind::zoom:
      fields.number("x", -1, 1, message.x);
      fields.number("y", -1, 1, message.y);
      return fields.number("factor", 0.01, 100, message.z);
    case Kind::fly:
      fields.number("right", -kMaxMove, kMaxMove, message.x);
      fields.number("up", -kMaxMove, kMaxMove, message.y);
      return fields.number("back", -kMaxMove, kMaxMove, message.z);
    case Kind::frame:
    case Kind::isolate:
      return fields.node(false, message);
    case Kind::codec:
      fields.flag("h264", message.on);
      return fields.optional_flag("vp8", message.vp8);
    case Kind::quality:
      return fields.flag("sharp", message.on);
    case Kind::camera:
      return fields.optional("index", message.index);
    case Kind::pick:
      fields.number("x", 0, 1, message.x);
      return fields.number("y", 0, 1, message.y);
    case Kind::inspect:
      return fields.node(true, message);
    case Kind::view:
      return fields.view(message.view);
    case Kind::plot:
      fields.flag("on", message.on);
      fields.integer("list", 0, UINT32_MAX, message.number);
      return fields.indices("scalars", kMaxPlotted, message.plotted);
    case Kind::plotted:
      return fields.integer("number", 1, UINT32_MAX, message.number);
    case Kind::hide:
      fields.node(true, message);
      return fields.flag("hidden", message.on);
    case Kind::show_all:
      return;
    case Kind::play:
      return fields.flag("playing", message.on);
    case Kind::step:
      return fields.flag("forwards", message.on);
    case Kind::seek:
      return fields.number("fraction", 0, 1, message.x);
    case Kind::joint:
      fields.integer("scene", 0, UINT64_MAX, message.scene);
      fields.integer("index", 0, UINT32_MAX - 1, message.index.emplace());
      return fields.number("position", -kMaxPosition, kMaxPosition, message.x);
    case Kind::posture:
      fields.integer("scene", 0, UINT64_MAX, message.scene);
      return fields.optional("index", message.index);
    case Kind::setting:
      fields.text("setting", 64, message.setting);
      fields.integer("control", 0, UINT32_MAX - 1, message.index.emplace());
      return fields.text("value", 64, message.value);
    case Kind::input:
      return read_input(fields, message);
  }
}

template <typename Integer>
void append(Integer value, std::vector<uint8_t>& message) {
  for (size_t byte = 0; byte < sizeof value; ++byte)
    message.push_back(static_cast<uint8_t>(static_cast<uint64_t>(value) >> (8 * byte)));
}

}  // namespace

bool needs_control(Kind kind) {
  return kind >= Kind::hide;
}

Result<ClientMessage> parse_message(std::string_view text) {
  if (text.size() > kMaxMessageBytes) return Error{"the message is too long"};
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return Error{"the message is not a JSON object"};
  const auto type = json.find("type");
  if (type == json.end() || !type->is_string()) return Error{"\"type\" must be a text"};
  for (const auto& [name, kind] : kKinds) {
    if (type->get_ref<const std::string&>() != name) continue;
    ClientMessage message;
    message.kind = kind;
    Fields fields(json);
    read_fields(fields, message);
    if (!fields.fault().empty()) return Error{std::string(name) + ": " + fields.fault()};
    return message;
  }
  return Error{"the type of the message is not known; reload the page"};
}

void append_header(const ImageHeader& header, std::vector<uint8_t>& message) {
  append(header.number, message);
  append(header.width, message);
  append(header.height, message);
  append(static_cast<uint8_t>(header.codec), message);
  append(static_cast<uint8_t>((header.is_refined ? 1 : 0) | (header.is_key ? 2 : 0)), message);
  append(uint16_t{0}, message);
  append(header.encode_us, message);
  append(header.sim_time_ns, message);
}

}  // namespace fire3dv::serve
