// Test of fire3dv-inspect's report of a renderer: what it reads from the metrics page.
#include <gtest/gtest.h>

#include "programs/inspect/renderer_page.h"

namespace fire3dv::inspect {
namespace {

constexpr const char* kPage = R"(# HELP fire3dv_images_total Images drawn.
# TYPE fire3dv_images_total counter
fire3dv_images_total 12
fire3dv_stream_info{stream="0",name="arm \"left\"\\",listener="shm://demo",clock="same_clock"} 1
fire3dv_stream_info{stream="1",name="cloud",listener="tcp://127.0.0.1:7345",clock="none"} 1
fire3dv_stream_drawing_seconds_total{stream="0"} 0.25
fire3dv_stream_drawing_seconds_total{stream="1"} 12.5
fire3dv_stream_drawing_share{stream="1"} 0.83
fire3dv_stream_content_hidden{stream="1"} 1
fire3dv_stream_drawing_share{stream="2} 7
fire3dv_stream_drawing_share{stream="3"} many
fire3dv_stream_drawing_share{stream="4"
)";

TEST(RendererPage, ListsStreamsByTheirCost) {
  const std::vector<DrawnStream> streams = read_page(kPage);
  ASSERT_EQ(streams.size(), 2u);
  EXPECT_EQ(streams[0].name, "cloud");
  EXPECT_EQ(streams[0].drawing_seconds, 12.5);
  EXPECT_EQ(streams[0].drawing_share, 0.83);
  EXPECT_TRUE(streams[0].is_hidden);
  EXPECT_EQ(streams[1].name, "arm \"left\"\\");
  EXPECT_FALSE(streams[1].is_hidden);
}

TEST(RendererPage, TextNamesCostAndHiddenContent) {
  const std::string text = text_of("http://127.0.0.1:9464", read_page(kPage));
  EXPECT_NE(
      text.find(
          "stream 1 \"cloud\" at tcp://127.0.0.1:7345: 12.5 s of drawing time, 83 % now, content hidden"),
      std::string::npos)
      << text;
}

TEST(RendererPage, UnreachableRendererIsNamed) {
  const auto page = fetch_page("http://127.0.0.1:1");
  ASSERT_FALSE(page.ok());
  EXPECT_NE(page.error().message.find("--metrics 127.0.0.1:1"), std::string::npos) << page.error().message;
  EXPECT_FALSE(fetch_page("http://").ok());
}

}  // namespace
}  // namespace fire3dv::inspect
