#include "adapters/ros2/bridge.h"

#include <utility>

#include "base/clock.h"
#include "base/plural.h"
#include "base/text.h"

namespace fire3dv::ros2 {
namespace {

constexpr int64_t kMs = 1'000'000, kSecond = 1000 * kMs;
constexpr int64_t kPatienceNs = 3 * kSecond;
constexpr int kMaxBatches = 64;  // of one topic, before poses are published

template <typename Message, typename Take>
void drain(Reader<Message>& reader, Take&& take) {
  for (int batch = 0; batch < kMaxBatches && reader.take(take) > 0; ++batch) {
  }
}

}  // namespace

Result<Bridge::Readers> Bridge::open_readers(const Participant& participant, const Options& options) {
  const auto name = [&](const char* topic) { return options.names.resolve(topic); };
  auto tf = Reader<TfMessage>::open(participant, name("/tf"), Profile::tf);
  auto tf_static = Reader<TfMessage>::open(participant, name("/tf_static"), Profile::tf_static);
  auto clock = Reader<ClockMessage>::open(participant, name("/clock"), Profile::clock);
  auto joints = Reader<JointStateMessage>::open(participant, name("joint_states"), Profile::joint_states);
  auto description =
      Reader<StringMessage>::open(participant, name("robot_description"), Profile::robot_description);
  if (!tf) return tf.error();
  if (!tf_static) return tf_static.error();
  if (!clock) return clock.error();
  if (!joints) return joints.error();
  if (!description) return description.error();
  return Readers{std::move(*tf), std::move(*tf_static), std::move(*clock), std::move(*joints),
                 std::move(*description)};
}

Result<std::unique_ptr<Bridge>> Bridge::open(Options options, DomainSettings settings) {
  Result<Renderers> renderers = Renderers::open(options.uris, options.security);
  if (!renderers) return renderers.error();
  Result<std::unique_ptr<Participant>> participant = Participant::open(std::move(settings));
  if (!participant) return participant.error();
  Result<Discovery> discovery = Discovery::open(**participant);
  if (!discovery) return discovery.error();
  Result<Readers> readers = open_readers(**participant, options);
  if (!readers) return readers.error();
  Entity waitset(dds_create_waitset((*participant)->get()));
  if (!waitset) return Error{"no waitset (" + dds_text(waitset.get()) + ")"};
  std::unique_ptr<Bridge> bridge(new Bridge(std::move(options), std::move(*participant),
                                            std::move(*discovery), std::move(*readers), std::move(waitset),
                                            std::move(*renderers)));
  if (Result<void> opened = bridge->open_images(); !opened) return opened.error();
  if (Result<void> opened = bridge->open_markers(); !opened) return opened.error();
  return bridge;
}

Bridge::Bridge(Options options, std::unique_ptr<Participant> participant, Discovery discovery,
               Readers readers, Entity waitset, Renderers renderers)
    : options_(std::move(options)),
      participant_(std::move(participant)),
      discovery_(std::move(discovery)),
      readers_(std::move(readers)),
      waitset_(std::move(waitset)),
      renderers_(std::move(renderers)),
      sampler_(options_.frames) {
  const Names& names = options_.names;
  watch({{names.resolve("/tf"), "tf2_msgs/msg/TFMessage", readers_.tf.get()},
         {names.resolve("/tf_static"), "tf2_msgs/msg/TFMessage", readers_.tf_static.get()},
         {names.resolve("/clock"), "rosgraph_msgs/msg/Clock", readers_.clock.get()},
         {names.resolve("joint_states"), "sensor_msgs/msg/JointState", readers_.joint_states.get()},
         {description_topic(), "std_msgs/msg/String", readers_.description.get()}});
}

// Waits for messages, and reports publishers of another type or quality of service.
void Bridge::watch(std::vector<WatchedTopic> topics) {
  for (WatchedTopic& topic : topics) {
    dds_set_status_mask(topic.reader, DDS_DATA_AVAILABLE_STATUS);
    dds_waitset_attach(waitset_.get(), topic.reader, 0);
    watched_.push_back(std::move(topic));
  }
}

Result<void> Bridge::run(const std::atomic<bool>& stop) {
  begun_ns_ = now_ns_ = monotonic_ns();
  next_report_ns_ = begun_ns_ + kSecond;
  log_line(domain_text(participant_->settings()));
  while (!stop) {
    dds_waitset_wait(waitset_.get(), nullptr, 0, DDS_MSECS(wait_time().count()));
    now_ns_ = monotonic_ns();
    take_messages();
    if (Result<void> done = poll_conversion(); !done) return done;
    take_markers();
    if (Result<void> done = publish(); !done) return done;
    poll_images();
    if (now_ns_ >= next_look_ns_) {
      next_look_ns_ = now_ns_ + 100 * kMs;
      if (Result<void> done = look_around(); !done) return done;
    }
  }
  renderers_.log_result(log_line);
  if (images_) images_->log_counts();
  return {};
}

// Static transforms first: moving ones may hang on them.
void Bridge::take_messages() {
  if (options_.reads_description)
    drain(readers_.description, [&](const StringMessage& message, const dds_sample_info_t&) {
      take_description(text_of(message.data));
    });
  drain(readers_.clock, [&](const ClockMessage& message, const dds_sample_info_t& info) {
    take_clock(message, info.publication_handle);
  });
  drain(readers_.tf_static, [&](const TfMessage& message, const dds_sample_info_t& info) {
    take_transforms(message, true, info.publication_handle);
  });
  drain(readers_.tf, [&](const TfMessage& message, const dds_sample_info_t& info) {
    take_transforms(message, false, info.publication_handle);
  });
  drain(readers_.joint_states,
        [&](const JointStateMessage& message, const dds_sample_info_t&) { take_joint_state(message); });
}

bool Bridge::insert_all(const TfMessage& message, bool is_static, SourceId source) {
  for (uint32_t i = 0; i < message.transforms._length; ++i) {
    const auto& transform = message.transforms._buffer[i];
    const auto& [translation, rotation] = transform.transform;
    const char* const child = text_of(transform.child_frame_id);
    const Insertion insertion = buffer_.insert(
        text_of(transform.header.frame_id), child, stamp_ns(transform.header.stamp),
        {{translation.x, translation.y, translation.z}, {rotation.x, rotation.y, rotation.z, rotation.w}},
        is_static, source, now_ns_);
    if (insertion == Insertion::accepted || insertion == Insertion::repeated ||
        insertion == Insertion::too_old)
      continue;
    log_.warn("refused transforms", "a transform of frame " + quote(child) + " from " + source_text(source) +
                                        " is refused: " + insertion_text(insertion));
  }
  return !is_static && buffer_.has_jumped_back(now_ns_);
}

void Bridge::take_transforms(const TfMessage& message, bool is_static, SourceId source) {
  last_transform_ns_ = now_ns_;
  if (!insert_all(message, is_static, source)) return;
  restart("the stamps of " + source_text(source));
  insert_all(message, is_static, source);
}

void Bridge::restart(const std::string& reason) {
  log_line(reason + " went back in time: poses start again");
  buffer_.clear_moving();
  sampler_.restart();
  joint_scalars_.restart();
  last_restart_ns_ = now_ns_;
}

void Bridge::take_clock(const ClockMessage& message, SourceId source) {
  switch (clock_.add(stamp_ns(message.clock), source, now_ns_)) {
    case ClockWatch::Event::none:
      break;
    case ClockWatch::Event::jumped_back:
      // Transforms may have come first.
      if (last_restart_ns_ == 0 || now_ns_ - last_restart_ns_ > kSecond) restart("/clock");
      break;
    case ClockWatch::Event::conflict:
      log_.warn("publishers of /clock", "/clock has two publishers, " + source_text(clock_.source()) +
                                            " and " + source_text(clock_.other()) + ": the first one counts");
      break;
  }
}

// A description that comes first saves a description of all frames, and scalars without units.
bool Bridge::waits_for_description() const {
  return options_.reads_description && !links_ &&
         (conversion_ || (description_.empty() && now_ns_ - begun_ns_ < kPatienceNs));
}

Result<void> Bridge::publish() {
  if (waits_for_description()) return {};
  const std::optional<PoseSampler::Frame> frame = sampler_.update(buffer_, now_ns_);
  if (!frame) return {};
  if (frame->is_new_layout) {
    const std::vector<std::string>& names = sampler_.node_names();
    if (Result<void> done = renderers_.describe(names, offsets(names)); !done) return done;
    log_line(counted(names.size(), "frame") + " in " + quote(buffer_.frames()[sampler_.fixed_frame()].name));
  }
  return renderers_.publish(frame->time_ns, sampler_.poses(), frame->is_discontinuity);
}

Result<void> Bridge::look_around() {
  discovery_.update();
  report_publishers();
  choose_source_of_links();
  report_conflicts();
  if (now_ns_ >= next_report_ns_) {
    next_report_ns_ = now_ns_ + kSecond;
    report_faults();
    report_silence();
  }
  return renderers_.poll(log_line);
}

}  // namespace fire3dv::ros2
