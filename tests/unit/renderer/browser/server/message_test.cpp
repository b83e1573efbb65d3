// Messages of the live view's page and headers of its images.
#include "renderer/browser/server/message.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

namespace fire3dv::serve {
namespace {

using Kind = ClientMessage::Kind;

TEST(ClientMessage, EachKindIsRead) {
  const auto read = [](const char* text) {
    const Result<ClientMessage> message = parse_message(text);
    EXPECT_TRUE(message.ok()) << text;
    return message.ok() ? *message : ClientMessage();
  };
  EXPECT_EQ(read(R"({"type":"hello","token":"abc"})").token, "abc");
  const ClientMessage size = read(R"({"type":"size","width":640,"height":4096})");
  EXPECT_EQ(size.kind, Kind::size);
  EXPECT_EQ(size.width, 640u);
  EXPECT_EQ(size.height, 4096u);
  EXPECT_EQ(read(R"({"type":"shown","image":7})").number, 7u);
  const ClientMessage orbit = read(R"({"type":"orbit","yaw":-0.5,"pitch":1})");
  EXPECT_EQ(orbit.x, -0.5);
  EXPECT_EQ(orbit.y, 1);
  EXPECT_EQ(read(R"({"type":"zoom","factor":2,"x":0,"y":-1})").z, 2);
  const ClientMessage frame = read(R"({"type":"frame","node":3,"scene":9})");
  EXPECT_EQ(frame.node, 3u);
  EXPECT_EQ(frame.scene, 9u);
  EXPECT_FALSE(read(R"({"type":"frame","node":null})").node);
  EXPECT_TRUE(read(R"({"type":"quality","sharp":true})").on);
  EXPECT_TRUE(read(R"({"type":"codec","h264":true})").on);
  EXPECT_TRUE(read(R"({"type":"codec","h264":false,"vp8":true})").vp8);
  EXPECT_EQ(read(R"({"type":"camera","index":1})").index, 1u);
  EXPECT_FALSE(read(R"({"type":"camera"})").index);
  EXPECT_TRUE(read(R"({"type":"hide","node":0,"scene":0,"hidden":true})").on);
  EXPECT_EQ(read(R"({"type":"seek","fraction":0.25})").x, 0.25);
  EXPECT_EQ(read(R"({"type":"inspect","node":3,"scene":9})").node, 3u);
  const ClientMessage view =
      read(R"({"type":"view","position":[1,2,-3],"rotation":[0,1,0,0],"distance":4,"fov":0.5})");
  EXPECT_EQ(view.view.position_m[2], -3);
  EXPECT_EQ(view.view.world_from_camera[1], 1);
  EXPECT_EQ(view.view.focus_distance_m, 4);
  EXPECT_EQ(view.view.vertical_fov_rad, 0.5);
  const ClientMessage plot = read(R"({"type":"plot","on":true,"list":7,"scalars":[5,3]})");
  EXPECT_TRUE(plot.on);
  EXPECT_EQ(plot.number, 7u);
  EXPECT_EQ(plot.plotted, (std::vector<uint32_t>{5, 3}));
  EXPECT_EQ(read(R"({"type":"plotted","number":9})").number, 9u);
  const ClientMessage joint = read(R"({"type":"joint","scene":4,"index":2,"position":-1.5})");
  EXPECT_EQ(joint.scene, 4u);
  EXPECT_EQ(joint.index, 2u);
  EXPECT_EQ(joint.x, -1.5);
  EXPECT_FALSE(read(R"({"type":"posture","scene":4})").index);
  const ClientMessage input =
      read(R"({"type":"input","list":3,"index":2,"action":"speed","value":0.5,"text":"a"})");
  EXPECT_EQ(input.number, 3u);
  EXPECT_EQ(input.index, 2u);
  EXPECT_EQ(input.action, wire::InputAction::speed);
  EXPECT_EQ(input.x, 0.5);
  EXPECT_EQ(input.value, "a");
  const ClientMessage setting = read(R"({"type":"setting","setting":"shadows","control":1,"value":"off"})");
  EXPECT_EQ(setting.setting, "shadows");
  EXPECT_EQ(setting.index, 1u);
  EXPECT_EQ(setting.value, "off");
  for (const char* text :
       {R"({"type":"pan","right":1,"up":2})", R"({"type":"fly","right":1,"up":2,"back":3})",
        R"({"type":"pick","x":0,"y":1})", R"({"type":"isolate"})", R"({"type":"show_all"})",
        R"({"type":"play","playing":false})", R"({"type":"step","forwards":true})"})
    read(text);
}

TEST(ClientMessage, BadOnesAreRefused) {
  for (const std::string& text :
       {std::string(),
        std::string("{"),
        std::string("[]"),
        std::string("{}"),
        std::string(R"({"type":1})"),
        std::string(R"({"type":"reboot"})"),
        std::string(R"({"type":"size","width":0,"height":1})"),
        std::string(R"({"type":"size","width":5000,"height":1})"),
        std::string(R"({"type":"size","width":1.5,"height":1})"),
        std::string(R"({"type":"size","width":-1,"height":1})"),
        std::string(R"({"type":"orbit","yaw":1e999,"pitch":0})"),
        std::string(R"({"type":"orbit","yaw":"1","pitch":0})"),
        std::string(R"({"type":"zoom","factor":0,"x":0,"y":0})"),
        std::string(R"({"type":"zoom","factor":1,"x":2,"y":0})"),
        std::string(R"({"type":"frame","node":3})"),
        std::string(R"({"type":"frame","node":4294967295,"scene":0})"),
        std::string(R"({"type":"hide","scene":0,"hidden":true})"),
        std::string(R"({"type":"play","playing":1})"),
        std::string(R"({"type":"quality","sharp":1})"),
        std::string(R"({"type":"codec","h264":true,"vp8":1})"),
        std::string(R"({"type":"shown","image":0})"),
        std::string(R"({"type":"view","position":[1,2],"rotation":[0,0,0,1],"distance":1,"fov":1})"),
        std::string(R"({"type":"view","position":[1,2,1e10],"rotation":[0,0,0,1],"distance":1,"fov":1})"),
        std::string(R"({"type":"view","position":[1,2,3],"rotation":[0,0,0,0],"distance":1,"fov":1})"),
        std::string(R"({"type":"view","position":[1,2,3],"rotation":[0,0,0,1],"distance":0,"fov":1})"),
        std::string(R"({"type":"view","position":[1,2,3],"rotation":[0,0,0,1],"distance":1,"fov":4})"),
        std::string(R"({"type":"plot","on":true,"list":0,"scalars":[0,1,2,3,4,5,6,7,8]})"),
        std::string(R"({"type":"plot","on":true,"list":0,"scalars":[-1]})"),
        std::string(R"({"type":"plotted","number":0})"),
        std::string(R"({"type":"inspect","scene":0})"),
        std::string(R"({"type":"joint","scene":0,"index":0,"position":1e7})"),
        std::string(R"({"type":"joint","scene":0,"index":0})"),
        std::string(R"({"type":"posture","index":1})"),
        std::string(R"({"type":"setting","setting":"shadows","control":-1,"value":"off"})"),
        std::string(R"({"type":"setting","setting":"shadows","control":0,"value":1})"),
        std::string(R"({"type":"input","list":0,"index":0,"action":"jump","value":0,"text":""})"),
        std::string(R"({"type":"input","list":0,"index":0,"action":"begin","value":0,"text":""})"),
        std::string(R"({"type":"input","list":0,"index":0,"action":"move","value":0,"text":""})"),
        std::string(R"({"type":"input","list":0,"index":0,"action":"end","value":0,"text":""})"),
        std::string(R"({"type":"input","list":0,"index":0,"action":"set","value":1e13,"text":""})"),
        std::string(R"({"type":"input","list":0,"action":"set","value":1,"text":""})"),
        R"({"type":"input","list":0,"index":0,"action":"set","value":1,"text":")" + std::string(1024, 'a') +
            "\"}",
        R"({"type":"setting","setting":"shadows","control":0,"value":")" + std::string(65, 'a') + "\"}",
        R"({"type":"hello","token":")" + std::string(200, 'a') + "\"}",
        std::string(3000, '['),
        R"({"type":"show_all","x":")" + std::string(kMaxMessageBytes, 'a') + "\"}"})
    EXPECT_FALSE(parse_message(text).ok()) << text.substr(0, 80);
  EXPECT_NE(parse_message(R"({"type":"orbit","yaw":1})").error().message.find("\"pitch\""),
            std::string::npos);
}

TEST(ClientMessage, SharedStateNeedsControl) {
  for (const Kind kind : {Kind::hide, Kind::isolate, Kind::show_all, Kind::play, Kind::step, Kind::seek,
                          Kind::joint, Kind::posture, Kind::setting, Kind::input})
    EXPECT_TRUE(needs_control(kind));
  for (const Kind kind : {Kind::hello, Kind::size, Kind::shown, Kind::orbit, Kind::pan, Kind::zoom, Kind::fly,
                          Kind::frame, Kind::codec, Kind::quality, Kind::camera, Kind::pick, Kind::inspect,
                          Kind::view, Kind::plot, Kind::plotted})
    EXPECT_FALSE(needs_control(kind));
}

TEST(ImageHeader, IsLittleEndian) {
  std::vector<uint8_t> message;
  append_header({0x01020304, 0x0506, 0x0708, Codec::h264, true, true, 0x090a0b0c, 0x1112131415161718},
                message);
  const std::vector<uint8_t> expected = {4,  3,  2,  1, 6,    5,    8,    7,    2,    3,    0,    0,
                                         12, 11, 10, 9, 0x18, 0x17, 0x16, 0x15, 0x14, 0x13, 0x12, 0x11};
  EXPECT_EQ(message, expected);
  EXPECT_EQ(message.size(), kImageHeaderBytes);
}

}  // namespace
}  // namespace fire3dv::serve
