// Fuzz target of the live view's messages: what is accepted is within the limits of its kind.
#include <cmath>
#include <string_view>

#include "base/error.h"
#include "renderer/browser/server/message.h"
#include "renderer/settings/setting_table.h"
#include "tests/fuzz/target.h"

namespace fire3dv::fuzz {

std::vector<Input> seeds() {
  std::vector<Input> inputs;
  for (const std::string_view text :
       {R"({"type":"hello","token":"0123456789abcdef0123456789abcdef"})",
        R"({"type":"size","width":1280,"height":720})",
        R"({"type":"shown","image":1})",
        R"({"type":"orbit","yaw":0.1,"pitch":-0.1})",
        R"({"type":"pan","right":0.1,"up":-0.1})",
        R"({"type":"zoom","factor":0.9,"x":0.1,"y":-0.1})",
        R"({"type":"fly","right":0,"up":0,"back":-1})",
        R"({"type":"frame","node":3,"scene":1})",
        R"({"type":"camera","index":2})",
        R"({"type":"pick","x":0.5,"y":0.5})",
        R"({"type":"hide","node":1,"scene":1,"hidden":true})",
        R"({"type":"isolate"})",
        R"({"type":"inspect","node":2,"scene":1})",
        R"({"type":"codec","h264":true,"vp8":false})",
        R"({"type":"quality","sharp":true})",
        R"({"type":"show_all"})",
        R"({"type":"play","playing":true})",
        R"({"type":"step","forwards":false})",
        R"({"type":"seek","fraction":0.5})",
        R"({"type":"view","position":[1,2,3],"rotation":[0,0,0,1],"distance":2,"fov":0.8})",
        R"({"type":"plot","on":true,"list":4,"scalars":[0,7]})",
        R"({"type":"plotted","number":1})",
        R"({"type":"joint","scene":1,"index":2,"position":-0.5})",
        R"({"type":"posture","scene":1,"index":0})",
        R"({"type":"setting","setting":"tone-map","control":0,"value":"none"})",
        R"({"type":"input","list":1,"index":0,"action":"set","value":0.5,"text":""})"})
    inputs.emplace_back(text.begin(), text.end());
  return inputs;
}

}  // namespace fire3dv::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace fire3dv;
  using Kind = serve::ClientMessage::Kind;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const Result<serve::ClientMessage> message = serve::parse_message(text);
  if (!message) {
    FIRE3DV_ASSERT(!message.error().message.empty());
    return 0;
  }
  FIRE3DV_ASSERT(size <= serve::kMaxMessageBytes);
  FIRE3DV_ASSERT(std::isfinite(message->x) && std::isfinite(message->y) && std::isfinite(message->z));
  const Kind kind = message->kind;
  if (kind == Kind::size)
    FIRE3DV_ASSERT(message->width > 0 && message->width <= serve::kMaxViewSide && message->height > 0 &&
                   message->height <= serve::kMaxViewSide);
  if (kind == Kind::zoom) FIRE3DV_ASSERT(message->z > 0 && std::abs(message->x) <= 1);
  if (kind == Kind::pick || kind == Kind::seek) FIRE3DV_ASSERT(message->x >= 0 && message->x <= 1);
  if (kind == Kind::plot) FIRE3DV_ASSERT(message->plotted.size() <= serve::kMaxPlotted);
  if (kind == Kind::joint) FIRE3DV_ASSERT(message->index && std::abs(message->x) <= 1e6);
  if (kind == Kind::setting) {
    FIRE3DV_ASSERT(message->index && message->value.size() <= 64);
    settings::DrawSettings draw;  // as LiveView::apply_setting()
    for (const settings::DrawSetting& row : settings::draw_setting_table())
      if (row.name == message->setting && *message->index < row.controls.size())
        (void)row.controls[*message->index].set(message->value, draw);
  }
  if (kind == Kind::view) {
    const serve::ClientMessage::View& view = message->view;
    double square = 0;
    for (const double part : view.world_from_camera) square += part * part;
    FIRE3DV_ASSERT(square > 0.25 && square < 5);
    FIRE3DV_ASSERT(view.focus_distance_m > 0 && view.vertical_fov_rad > 0 && view.vertical_fov_rad < 3.2);
    for (const double metres : view.position_m) FIRE3DV_ASSERT(std::isfinite(metres));
  }
  if (kind == Kind::input)
    FIRE3DV_ASSERT(message->index && message->value.size() <= wire::kMaxInputTextBytes &&
                   static_cast<size_t>(message->action) < wire::kInputActionCount);
  if (kind == Kind::hide || kind == Kind::inspect) FIRE3DV_ASSERT(message->node.has_value());
  return 0;
}
