// Messages between the page of the live view and this process, over its WebSocket: JSON text from the page,
// and images in binary messages to it. docs/design/live-view.md lists them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "protocol/wire/input.h"

namespace fire3dv::serve {

constexpr size_t kMaxMessageBytes = 4096;  // of a page's message
constexpr uint32_t kMaxViewSide = 4096;    // pixels
constexpr size_t kMaxPlotted = 8;          // scalars of one page's plot

// A message of a page. Fields that its kind does not name have no meaning.
struct ClientMessage {
  enum class Kind : uint8_t {
    hello,    // token
    size,     // width, height of the canvas
    shown,    // number: an image is on the display
    orbit,    // x: yaw, y: pitch, radians
    pan,      // x: right, y: up, fractions of the focus distance
    zoom,     // z: factor on the focus distance; x, y: fixed point in NDC
    fly,      // x: right, y: up, z: back, in radii of the scene
    frame,    // node, or the whole scene
    quality,  // on: sharp images instead of smooth motion
    codec,    // on, vp8: the page decodes H.264, VP8; also asks for a key frame
    camera,   // index of the scene's camera; none: a free camera at its pose
    pick,     // x, y: pixel as a fraction of the image
    inspect,  // node: its name, pose and stream
    view,     // pose, distance, fov: a free camera
    plot,     // on: scalars are listed; number of the list, and the plotted ones as its indices
    plotted,  // number: samples are on the display
    hide,     // node, on
    isolate,  // node, or none
    show_all,
    play,     // on
    step,     // on: forwards
    seek,     // x: fraction of the recording
    joint,    // scene, index of the listed joint, x: position, radians or metres
    posture,  // scene, index of a named pose; none: as in the file
    setting,  // setting: a row of the table; index of its control, value as in "settings"
    input,    // number of the list of inputs, index of an input in it, action; x: number, value: text
  };
  Kind kind = Kind::hello;
  std::string token, setting, value;
  wire::InputAction action{};
  uint32_t width = 0, height = 0;
  uint32_t number = 0;
  std::optional<uint32_t> node, index;
  uint64_t scene = 0;  // number of the scene that `node`, or `index` of joints and poses, belongs to
  double x = 0, y = 0, z = 0;
  struct View {
    std::array<double, 3> position_m{};
    std::array<double, 4> world_from_camera{};  // quaternion x y z w, not of length 0
    double focus_distance_m = 1, vertical_fov_rad = 1;
  };
  View view;
  std::vector<uint32_t> plotted;  // at most kMaxPlotted
  bool on = false, vp8 = false;
};

// Kinds that change what all viewers see.
bool needs_control(ClientMessage::Kind kind);

// Parses a message; all numbers are finite and within the limits of their kind. The error names the field.
Result<ClientMessage> parse_message(std::string_view text);

enum class Codec : uint8_t { jpeg = 1, h264 = 2, vp8 = 3 };

// Header of a binary message, before the encoded image.
struct ImageHeader {
  uint32_t number = 0;  // of the viewer's images, from 1
  uint16_t width = 0, height = 0;
  Codec codec = Codec::jpeg;
  bool is_key = false;      // video: needs no earlier image
  bool is_refined = false;  // full size, quality and samples: no better image of this moment follows
  uint32_t encode_us = 0;   // duration of encoding
  int64_t sim_time_ns = 0;
};
constexpr size_t kImageHeaderBytes = 24;
// Little-endian: u32 number, u16 width, u16 height, u8 codec, u8 flags (1: refined, 2: key), u16 0, u32
// encode_us, i64 sim_time_ns.
void append_header(const ImageHeader& header, std::vector<uint8_t>& message);

}  // namespace fire3dv::serve
