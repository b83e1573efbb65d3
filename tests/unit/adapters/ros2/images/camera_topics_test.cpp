// Messages of a camera, as a reader of the same process gets them: stamps, frames, rows, demand, readers that
// stop.
#include <fire3dv/image.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "adapters/ros2/dds/topics.h"
#include "adapters/ros2/images/camera_images.h"
#include "adapters/ros2/images/camera_topics.h"
#include "adapters/ros2/images/image_worker.h"
#include "adapters/ros2/images/messages.h"
#include "adapters/ros2/images/optical_frames.h"

namespace fire3dv::ros2 {
namespace {

constexpr uint32_t kWidth = 3, kHeight = 2;

// Domain of this process alone.
class CameraTopicsTest : public testing::Test {
 protected:
  void SetUp() override {
    DomainSettings settings;
    settings.domain_id = 91;
    settings.range = DiscoveryRange::off;
    auto opened = Participant::open(settings);
    ASSERT_TRUE(opened) << opened.error().message;
    participant_ = std::move(*opened);
    camera_.name = "front";
    camera_.topic = "cam/front";
    camera_.parent_frame = "base";
    camera_.optical_frame = "front_optical_frame";
    camera_.width = kWidth;
    camera_.height = kHeight;
  }

  template <typename Message>
  Reader<Message> reader(const std::string& topic, Profile profile) {
    auto opened = Reader<Message>::open(*participant_, topic, profile);
    EXPECT_TRUE(opened) << opened.error().message;
    return std::move(*opened);
  }

  CameraTopics open(const CameraSpec& camera) {
    auto topics = CameraTopics::open(*participant_, names_, camera);
    EXPECT_TRUE(topics) << topics.error().message;
    return std::move(*topics);
  }

  // An image of all planes; rows have a gap.
  fire3dv_image image(int64_t sim_time_ns) {
    for (size_t i = 0; i < color_.size(); ++i) color_[i] = static_cast<uint8_t>(i);
    for (size_t i = 0; i < depth_.size(); ++i) depth_[i] = static_cast<float>(i) + 0.5f;
    for (size_t i = 0; i < labels_.size(); ++i) labels_[i] = static_cast<uint32_t>(i) + 7;
    planes_ = {{FIRE3DV_IMAGE_COLOR_SRGB8, kWidth, kHeight, 4 * kStride, color_.data()},
               {FIRE3DV_IMAGE_DEPTH_F32, kWidth, kHeight, 4 * kStride, depth_.data()},
               {FIRE3DV_IMAGE_INSTANCE_U32, kWidth, kHeight, 4 * kStride, labels_.data()}};
    fire3dv_image image{};
    image.sequence = 1;
    image.sim_time_ns = sim_time_ns;
    image.width = kWidth;
    image.height = kHeight;
    image.fx = 100;
    image.fy = 101;
    image.cx = 1;
    image.cy = 0.5f;
    image.plane_count = planes_.size();
    image.planes = planes_.data();
    return image;
  }

  static constexpr uint32_t kStride = 5;
  std::unique_ptr<Participant> participant_;
  Names names_;
  CameraSpec camera_;
  std::vector<uint8_t> color_ = std::vector<uint8_t>(4 * kStride * kHeight);
  std::vector<float> depth_ = std::vector<float>(kStride * kHeight);
  std::vector<uint32_t> labels_ = std::vector<uint32_t>(kStride * kHeight);
  std::vector<fire3dv_image_plane> planes_;
};

std::vector<uint8_t> bytes_of(const dds_sequence_uint8& data) {
  return {data._buffer, data._buffer + data._length};
}

TEST_F(CameraTopicsTest, DemandFollowsReaders) {
  camera_.depth = camera_.compressed = true;
  camera_.labels = LabelSource::semantic;
  const CameraTopics topics = open(camera_);
  EXPECT_EQ(topics.wanted_outputs(), 0u);
  {
    const auto info = reader<CameraInfoMessage>("/cam/front/camera_info", Profile::camera_info);
    EXPECT_EQ(topics.wanted_outputs(), uint32_t{FIRE3DV_IMAGE_DEPTH_F32}) << "its stamp needs an image";
    const auto jpeg = reader<CompressedImageMessage>("/cam/front/image_raw/compressed", Profile::image);
    EXPECT_EQ(topics.wanted_outputs(), uint32_t{FIRE3DV_IMAGE_COLOR_SRGB8});
  }
  EXPECT_EQ(topics.wanted_outputs(), 0u) << "the readers are gone";
  const auto depth = reader<ImageMessage>("/cam/front/depth/image_raw", Profile::image);
  const auto labels = reader<ImageMessage>("/cam/front/labels", Profile::image);
  EXPECT_EQ(topics.wanted_outputs(), uint32_t{FIRE3DV_IMAGE_DEPTH_F32 | FIRE3DV_IMAGE_SEMANTIC_U32});
}

TEST_F(CameraTopicsTest, Messages) {
  camera_.depth = true;
  camera_.labels = LabelSource::instance;
  CameraTopics topics = open(camera_);
  auto color = reader<ImageMessage>("/cam/front/image_raw", Profile::image);
  auto depth = reader<ImageMessage>("/cam/front/depth/image_raw", Profile::image);
  auto labels = reader<ImageMessage>("/cam/front/labels", Profile::image);
  auto info = reader<CameraInfoMessage>("/cam/front/camera_info", Profile::camera_info);
  auto depth_info = reader<CameraInfoMessage>("/cam/front/depth/camera_info", Profile::camera_info);
  const fire3dv_image sent = image(930'000'000'123);
  const Result<void> published = topics.publish(sent);
  ASSERT_TRUE(published) << published.error().message;

  const auto check_image = [&](const ImageMessage& message, const char* encoding, uint32_t pixel_bytes) {
    EXPECT_EQ(message.header.stamp.sec, 930);
    EXPECT_EQ(message.header.stamp.nanosec, 123u);
    EXPECT_STREQ(message.header.frame_id, "front_optical_frame");
    EXPECT_STREQ(message.encoding, encoding);
    EXPECT_EQ(message.width, kWidth);
    EXPECT_EQ(message.height, kHeight);
    EXPECT_EQ(message.step, pixel_bytes * kWidth) << "rows are tight";
    EXPECT_EQ(message.is_bigendian, 0);
  };
  const size_t colors = color.take([&](const ImageMessage& message, const dds_sample_info_t&) {
    check_image(message, "rgb8", 3);
    EXPECT_EQ(bytes_of(message.data),
              (std::vector<uint8_t>{0, 1, 2, 4, 5, 6, 8, 9, 10, 20, 21, 22, 24, 25, 26, 28, 29, 30}));
  });
  EXPECT_EQ(colors, 1u);
  const size_t depths = depth.take([&](const ImageMessage& message, const dds_sample_info_t&) {
    check_image(message, "32FC1", 4);
    ASSERT_EQ(message.data._length, 24u);
    float metres[6];
    std::memcpy(metres, message.data._buffer, sizeof metres);
    EXPECT_EQ(metres[2], 2.5f);
    EXPECT_EQ(metres[3], 5.5f);
  });
  EXPECT_EQ(depths, 1u);
  const size_t label_images = labels.take([&](const ImageMessage& message, const dds_sample_info_t&) {
    check_image(message, "32SC1", 4);
    ASSERT_EQ(message.data._length, 24u);
    int32_t ids[6];
    std::memcpy(ids, message.data._buffer, sizeof ids);
    EXPECT_EQ(ids[3], 12);
  });
  EXPECT_EQ(label_images, 1u);
  for (auto* const infos : {&info, &depth_info}) {
    const size_t count = infos->take([&](const CameraInfoMessage& message, const dds_sample_info_t&) {
      EXPECT_EQ(message.header.stamp.sec, 930);
      EXPECT_EQ(message.header.stamp.nanosec, 123u);
      EXPECT_STREQ(message.header.frame_id, "front_optical_frame");
      EXPECT_EQ(message.width, kWidth);
      EXPECT_EQ(message.height, kHeight);
      EXPECT_STREQ(message.distortion_model, "plumb_bob");
      EXPECT_EQ(message.d._length, 5u);
      EXPECT_EQ(message.k[0], 100);
      EXPECT_EQ(message.k[4], 101);
      EXPECT_EQ(message.k[5], 0.5);
      EXPECT_EQ(message.p[2], 1);
      EXPECT_EQ(message.r[8], 1);
    });
    EXPECT_EQ(count, 1u);
  }
}

TEST_F(CameraTopicsTest, CompressedImage) {
  camera_.compressed = true;
  CameraTopics topics = open(camera_);
  auto jpeg = reader<CompressedImageMessage>("/cam/front/image_raw/compressed", Profile::image);
  ASSERT_TRUE(topics.publish(image(-1)));
  const size_t count = jpeg.take([&](const CompressedImageMessage& message, const dds_sample_info_t&) {
    EXPECT_STREQ(message.format, "rgb8; jpeg compressed bgr8");
    EXPECT_EQ(message.header.stamp.sec, -1);
    EXPECT_EQ(message.header.stamp.nanosec, 999'999'999u);
    ASSERT_GT(message.data._length, 4u);
    EXPECT_EQ(message.data._buffer[0], 0xFF);  // start of image
    EXPECT_EQ(message.data._buffer[1], 0xD8);
    EXPECT_EQ(message.data._buffer[message.data._length - 1], 0xD9);  // end of image
  });
  EXPECT_EQ(count, 1u);
}

TEST_F(CameraTopicsTest, StoppedReaderBlocksNobody) {
  CameraTopics topics = open(camera_);
  auto stopped = reader<ImageMessage>("/cam/front/image_raw", Profile::image);  // takes nothing until the end
  for (int64_t i = 1; i <= 1000; ++i) {
    const Result<void> published = topics.publish(image(i));
    ASSERT_TRUE(published) << i << ": " << published.error().message;
  }
  const size_t count = stopped.take([&](const ImageMessage& message, const dds_sample_info_t&) {
    EXPECT_EQ(message.header.stamp.nanosec, 1000u) << "the newest wins";
  });
  EXPECT_EQ(count, 1u);
}

TEST_F(CameraTopicsTest, OpticalFramesReachLateReaders) {
  CameraSpec left = camera_, foreign = camera_;
  left.name = "left";
  left.optical_frame = "left_optical_frame";
  left.xyz = {1, 2, 3};
  foreign.optical_frame = "robot_link";
  foreign.publishes_frame = false;
  auto frames = OpticalFrames::open(*participant_, names_);
  ASSERT_TRUE(frames) << frames.error().message;
  ASSERT_TRUE(frames->publish({camera_}));
  ASSERT_TRUE(frames->publish({camera_, foreign, left}));
  auto own = reader<TfMessage>("/tf_static", Profile::tf_static);  // of the program itself
  // Another participant of the process and the domain.
  const Entity participant(dds_create_participant(91, nullptr, nullptr));
  const MessageType& type = kMessageType<TfMessage>;
  const Entity topic(dds_create_topic(participant.get(), type.descriptor, "rt/tf_static", nullptr, nullptr));
  const UniqueQos qos = reader_qos(Profile::tf_static, type);
  const Entity late(dds_create_reader(participant.get(), topic.get(), qos.get(), nullptr));
  ASSERT_TRUE(late);
  size_t messages = 0;
  for (int i = 0; i < 500 && messages == 0; ++i) {
    void* sample = nullptr;
    dds_sample_info_t info;
    if (dds_take(late.get(), &sample, &info, 1, 1) == 1 && info.valid_data) {
      ++messages;
      const auto& message = *static_cast<const TfMessage*>(sample);
      ASSERT_EQ(message.transforms._length, 2u);
      const auto& first = message.transforms._buffer[0];
      const auto& second = message.transforms._buffer[1];
      EXPECT_STREQ(first.header.frame_id, "base");
      EXPECT_STREQ(first.child_frame_id, "front_optical_frame");
      EXPECT_STREQ(second.child_frame_id, "left_optical_frame");
      EXPECT_EQ(second.transform.translation.y, 2);
      EXPECT_NEAR(first.transform.rotation.x, -0.5, 1e-12);
      EXPECT_NEAR(first.transform.rotation.y, 0.5, 1e-12);
      EXPECT_NEAR(first.transform.rotation.z, -0.5, 1e-12);
      EXPECT_NEAR(first.transform.rotation.w, 0.5, 1e-12);
      dds_return_loan(late.get(), &sample, 1);
    }
    if (messages == 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(messages, 1u);
  EXPECT_EQ(own.take([](const TfMessage&, const dds_sample_info_t&) {}), 0u)
      << "own frames are not read again";
}

TEST_F(CameraTopicsTest, CollidingCamerasAreRefused) {
  auto images = CameraImages::open(*participant_, names_, [](const std::string&) {});
  ASSERT_TRUE(images) << images.error().message;
  ASSERT_TRUE((*images)->add(camera_));
  const auto refusal = [&](const CameraSpec& camera) {
    const Result<void> added = (*images)->add(camera);
    return added ? "accepted" : added.error().message;
  };
  EXPECT_NE(refusal(camera_).find("given twice"), std::string::npos);
  CameraSpec other = camera_;
  other.name = "other";
  other.topic = "/cam/front";  // the same once it is resolved
  EXPECT_NE(refusal(other).find("has the topic of camera \"front\""), std::string::npos);
  other.topic = "other";
  EXPECT_NE(refusal(other).find("has the frame of camera \"front\""), std::string::npos);
  other.publishes_frame = false;
  EXPECT_EQ(refusal(other), "accepted");
  EXPECT_EQ((*images)->size(), 2u);
  EXPECT_TRUE((*images)->has("other"));
}

TEST(RosTime, TimeRoundsDown) {
  const auto is = [](int64_t ns, int32_t sec, uint32_t nanosec) {
    const auto time = ros_time(ns);
    return time.sec == sec && time.nanosec == nanosec;
  };
  EXPECT_TRUE(is(0, 0, 0));
  EXPECT_TRUE(is(1'500'000'000, 1, 500'000'000));
  EXPECT_TRUE(is(-1, -1, 999'999'999));
  EXPECT_TRUE(is(-1'000'000'000, -1, 0));
  EXPECT_TRUE(is(INT64_MAX, INT32_MAX, 999'999'999));
  EXPECT_TRUE(is(INT64_MIN, INT32_MIN, 0));
}

}  // namespace
}  // namespace fire3dv::ros2
