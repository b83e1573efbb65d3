#include "adapters/gazebo/stream/session.h"

#include <algorithm>
#include <utility>

#include "adapters/gazebo/stream/world_finder.h"
#include "adapters/gazebo/wire/field_count.h"
#include "base/clock.h"
#include "base/output/output_file.h"
#include "base/plural.h"
#include "base/text.h"

namespace fire3dv::gazebo {
namespace {

constexpr int64_t kSettle_ns = 1'200 * kMillisecondNs;  // from the first world on: one heartbeat of others
constexpr int64_t kPatience_ns = 3 * kSecondNs;         // until the user hears why nothing happens
constexpr int64_t kRequestPeriod_ns = 500 * kMillisecondNs;
constexpr int64_t kResponsePatience_ns = 3 * kSecondNs;
constexpr size_t kMaxMessagesAtOnce = 1000;
constexpr int kWait_ms = 10;
constexpr size_t kMaxFields = 8'000'000;  // of one message; a world of 200,000 entities has below 5 million

template <typename T>
bool parse(T& message, const std::vector<std::byte>& data) {
  return data.size() <= size_t{INT32_MAX} && has_at_most_fields(data, kMaxFields) &&
         message.ParseFromArray(data.data(), static_cast<int>(data.size()));
}

}  // namespace

Session::Session(std::unique_ptr<Node> node, Publisher publisher,
                 std::vector<std::filesystem::path> resource_folders, SessionOptions options, Log log)
    : node_(std::move(node)),
      publisher_(std::move(publisher)),
      resource_folders_(std::move(resource_folders)),
      options_(std::move(options)),
      log_(std::move(log)),
      assets_(resource_folders_),
      cameras_(options_.cameras) {}

void Session::report(const std::vector<std::string>& warnings) {
  constexpr size_t kMaxLines = 20;
  for (size_t i = 0; i < warnings.size(); ++i) {
    if (i == kMaxLines) return log_("warning: and " + counted(warnings.size() - i, "more warning"));
    log_("warning: " + warnings[i]);
  }
}

Result<void> Session::run(const std::atomic<bool>& stop) {
  begun_ns_ = monotonic_ns();
  while (!stop && !is_done_) {
    lose_server(node_->wait(kWait_ms));
    const int64_t now_ns = monotonic_ns();
    if (world_name_.empty()) {
      if (Result<void> found = find_world(now_ns); !found) return found;
    }
    if (!world_name_.empty() && !server_) find_server();
    if (server_) {
      follow_topics();
      request_scene(now_ns);
    }
    if (node_->was_refused() && !std::exchange(has_reported_refused_, true))
      log_(
          "warning: the world refuses this connection, so it sends no poses: set GZ_TRANSPORT_USERNAME and "
          "GZ_TRANSPORT_PASSWORD as there, or unset them if it has none");
    if (Result<void> done = receive_scene(); !done) return done;
    if (Result<void> done = receive_messages(); !done) return done;
    if (Result<void> done = receive_assets(); !done) return done;
    if (has_scene_ && !is_done_) {
      if (Result<void> done = publish(); !done) return done;
      report(cameras_.deliver(*node_, publisher_));
    }
    // Descriptions precede the assets with their nodes.
    const bool has_assets = std::any_of(world_.items().begin(), world_.items().end(),
                                        [](const TopLevel& item) { return !item.added_node.empty(); });
    for (const std::string& message : publisher_.poll(has_assets)) log_(message);
  }
  return {};
}

void Session::log_totals() {
  for (const Publisher::Totals& total : publisher_.totals())
    log_(total.uri + ": " + counted(total.published, "frame") + " published, " +
         std::to_string(total.dropped) + " overtaken");
}

Result<void> Session::find_world(int64_t now_ns) {
  if (!world_seen_ns_ && has_news(searched_for_world_) && !world_names(node_->directory()).empty())
    world_seen_ns_ = now_ns;
  // A named world waits for no others.
  const bool is_settled =
      world_seen_ns_ && (!options_.world.empty() || now_ns - *world_seen_ns_ >= kSettle_ns);
  if (is_settled && has_news(chosen_from_)) {
    const Result<std::optional<std::string>> chosen = choose_world(node_->directory(), options_.world);
    if (!chosen) return chosen.error();
    if (*chosen) world_name_ = **chosen;
  }
  if (world_name_.empty() && !has_reported_missing_ && now_ns - begun_ns_ >= kPatience_ns) {
    has_reported_missing_ = true;
    log_("warning: " + missing_world_advice(node_->directory(), options_.world, node_->interfaces()));
  }
  return {};
}

bool Session::has_news(std::optional<uint64_t>& searched) const {
  const uint64_t version = node_->directory().version();
  return std::exchange(searched, version) != version;
}

void Session::find_server() {
  if (!has_news(searched_for_server_)) return;
  const std::vector<Advertisement> services = node_->directory().services(topic("scene/info"));
  if (services.empty()) return;
  if (services.size() > 1)
    log_("warning: " + std::to_string(services.size()) + " processes serve world " + quote(world_name_) +
         ": the one at " + services.front().address + " is shown; stop the others, or give each a partition");
  server_ = services.front();
  searched_for_topics_.reset();
  log_("world " + quote(world_name_) + " at " + server_->address + " (" + server_->response_type + ")");
  scene_request_ = 0;
  failed_requests_ = 0;
  needs_scene_ = true;
  is_jump_ = true;
  world_.forget_times();
}

void Session::lose_server(const std::vector<std::string>& ended) {
  for (const std::string& uuid : ended) {
    node_->unsubscribe(uuid);
    if (!server_ || server_->process_uuid != uuid) continue;
    server_.reset();
    log_("world " + quote(world_name_) +
         " has ended; its last state stays, and it is followed when it comes back");
  }
}

void Session::follow_topics() {
  if (!has_news(searched_for_topics_)) return;
  for (const char* name : {"dynamic_pose/info", "pose/info", "scene/info", "scene/deletion"}) {
    for (const Advertisement& publisher : node_->directory().publishers(topic(name)))
      if (publisher.process_uuid == server_->process_uuid) node_->subscribe(publisher);
  }
}

void Session::request_scene(int64_t now_ns) {
  if (scene_request_ != 0 && now_ns >= next_request_ns_ - kRequestPeriod_ns + kResponsePatience_ns) {
    scene_request_ = 0;
    needs_scene_ = true;
    if (++failed_requests_ == 1)
      log_("warning: no answer from " + server_->address + " for " + topic("scene/info") +
           ": can that host reach this one (GZ_IP, --ip, a firewall)? Asking again");
  }
  if (!needs_scene_ || scene_request_ != 0 || now_ns < next_request_ns_) return;
  next_request_ns_ = now_ns + kRequestPeriod_ns;
  const Result<uint64_t> request = node_->request(*server_, {});
  if (!request) return log_("warning: " + request.error().message);
  needs_scene_ = false;
  scene_request_ = *request;
}

Result<void> Session::receive_scene() {
  while (const std::optional<Response> response = node_->next_response()) {
    if (response->request != scene_request_) continue;
    scene_request_ = 0;
    pb::Scene scene;
    if (!response->is_success || !parse(scene, response->data)) {
      log_("warning: the answer to " + topic("scene/info") + " is not a scene; asking again");
      needs_scene_ = true;
      continue;
    }
    // Servers answer before their world is loaded. What is deleted later is announced.
    if (scene.model().empty() && scene.light().empty()) {
      needs_scene_ = true;
      if (!std::exchange(has_reported_waiting_, true)) log_("the world is empty so far");
      continue;
    }
    World::Changes changes = world_.update(scene);
    report(world_.take_warnings());
    const Result<void> done = has_scene_ ? apply(std::move(changes)) : first_scene();
    if (!done) return done;
    needs_frame_ = true;
    cameras_.update(world_.items(), world_name_, server_ ? server_->response_type : "");
  }
  return {};
}

Result<void> Session::first_scene() {
  has_scene_ = true;
  size_t lights = 0, entities = 0;
  for (size_t i = 0; i < world_.items().size(); ++i) {
    TopLevel& item = world_.item(i);
    entities += item.entities.size();
    lights += item.entities.front().light != nullptr;
    item.is_in_file = item.is_streamed = !options_.add_scene;
    if (options_.add_scene) place_below(item, scene_node());
  }
  log_("scene: " + counted(world_.items().size() - lights, "model") + " and " + counted(lights, "light") +
       " with " + counted(entities, "node"));
  if (!options_.write_scene.empty()) {
    const ConvertedAsset scene = convert_items(world_.items(), resource_folders_, world_name_, true);
    report(scene.warnings);
    if (!scene.glb) return Error{options_.write_scene.string() + ": " + scene.glb.error().message};
    if (Result<void> written = base::write_output(options_.write_scene, *scene.glb); !written) return written;
    log_("scene written: fire3dv " + options_.write_scene.string() + " shows it");
    if (options_.ends_after_scene) {
      is_done_ = true;
      return {};
    }
  }
  if (options_.add_scene) assets_.push(world_.items());
  needs_describe_ = !options_.add_scene;  // else with the asset
  return {};
}

Result<void> Session::apply(World::Changes changes) {
  for (const TopLevel& item : changes.removed) {
    // Nodes of the scene file, and of an asset with several models, go one by one.
    const std::string& root = item.entities.front().name;
    const bool is_alone = !item.is_in_file && std::none_of(world_.items().begin(), world_.items().end(),
                                                           [&](const TopLevel& other) {
                                                             return other.added_node == item.added_node;
                                                           });
    if (!item.is_streamed) continue;  // still being converted
    needs_describe_ = true;
    if (Result<void> done =
            is_alone ? publisher_.undo(item.added_node) : publisher_.remove_node(item.entities.front().node);
        !done)
      return done;
    log_("removed " + quote(root));
  }
  for (const size_t index : changes.restored) {
    if (Result<void> done = publisher_.undo(world_.item(index).entities.front().node); !done) return done;
    log_("added again: " + quote(world_.item(index).entities.front().name));
    needs_describe_ = true;
  }
  for (const size_t index : changes.added) {
    TopLevel& item = world_.item(index);
    place_below(item, "added " + std::to_string(next_added_++) + ": " +
                          printable_text(item.entities.front().name, 256));
    assets_.push({item});
  }
  return {};
}

Result<void> Session::receive_assets() {
  while (const std::optional<ConvertedAsset> asset = assets_.take()) {
    report(asset->warnings);
    std::vector<TopLevel*> shown;
    for (size_t i = 0; i < world_.items().size(); ++i)
      if (world_.item(i).added_node == asset->node) shown.push_back(&world_.item(i));
    if (shown.empty()) continue;  // removed meanwhile
    const std::string name = quote(shown.front()->entities.front().name);
    if (!asset->glb) {
      log_("warning: " + name + " is not shown: " + asset->glb.error().message);
      continue;
    }
    // A model that is too large for the stream is no reason to end.
    if (const Result<void> done = publisher_.add_asset(asset->node, *asset->glb); !done) {
      log_("warning: " + name + " is not shown: " + done.error().message);
      continue;
    }
    log_("added " + (shown.front()->added_node == scene_node() ? "the scene" : name));
    for (TopLevel* item : shown) item->is_streamed = true;
    needs_describe_ = needs_frame_ = true;
  }
  return {};
}

Result<void> Session::receive_messages() {
  for (size_t i = 0; i < kMaxMessagesAtOnce; ++i) {
    const std::optional<Message> message = node_->next_message();
    if (!message) break;
    if (!has_scene_) continue;
    Result<void> done;
    if (message->name == topic("dynamic_pose/info")) {
      done = receive_poses(*message, PoseTopic::dynamic);
    } else if (message->name == topic("pose/info")) {
      done = receive_poses(*message, PoseTopic::full);
    } else if (message->name == topic("scene/info")) {
      needs_scene_ = true;
    } else if (message->name == topic("scene/deletion")) {
      pb::UInt32V ids;
      if (!parse(ids, message->data)) continue;
      auto [changes, is_whole] = world_.remove(ids);
      needs_scene_ |= !is_whole;
      done = apply(std::move(changes));
      cameras_.update(world_.items(), world_name_, server_ ? server_->response_type : "");
      needs_frame_ = true;
    }
    if (!done) return done;
  }
  if (world_.invalid_poses() > reported_invalid_ && reported_invalid_ == 0)
    log_("warning: poses with numbers that are not finite, or no rotations, are ignored");
  reported_invalid_ = world_.invalid_poses();
  return {};
}

Result<void> Session::receive_poses(const Message& message, PoseTopic topic) {
  pb::PoseV poses;
  if (!parse(poses, message.data)) return {};
  const World::PoseResult result = world_.apply(poses, topic, monotonic_ns());
  needs_scene_ |= result.has_unknown;
  if (result.is_reset) {
    log_("simulated time went back to " + std::to_string(static_cast<double>(result.sim_time_ns) * 1e-9) +
         " s: the world was reset");
    is_jump_ = needs_describe_ = needs_scene_ = true;
  }
  if (!result.is_frame) return {};
  sim_time_ns_ = result.sim_time_ns;
  needs_frame_ = true;
  const Result<void> done = publish();
  is_jump_ = false;
  return done;
}

Result<void> Session::describe() {
  needs_describe_ = false;
  needs_frame_ = true;
  cameras_.restart();
  return publisher_.describe(world_.node_names(), "gazebo:" + world_name_);
}

Result<void> Session::publish() {
  if (needs_describe_) {
    if (Result<void> done = describe(); !done) return done;
  }
  if (!needs_frame_ || !publisher_.is_described()) return {};
  needs_frame_ = false;
  world_.write_poses(poses_);
  if (poses_.empty()) return {};
  if (Result<void> sent = publisher_.publish(sim_time_ns_, poses_, is_jump_); !sent) return sent;
  report(cameras_.request(*node_, publisher_, sim_time_ns_));
  return {};
}

}  // namespace fire3dv::gazebo
