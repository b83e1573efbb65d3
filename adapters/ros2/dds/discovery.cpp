#include "adapters/ros2/dds/discovery.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <set>

#include "adapters/ros2/dds/names.h"
#include "base/plural.h"
#include "base/text.h"

namespace fire3dv::ros2 {
namespace {

constexpr size_t kMaxListed = 10, kMaxKnown = 10000, kMaxTopicNameBytes = 256;

std::string guid_text(const dds_guid_t& guid) {
  std::string text;
  for (const uint8_t byte : guid.v) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02x", byte);
    text += digits;
  }
  return text;
}

std::string property(const dds_qos_t* qos, const char* name) {
  char* value = nullptr;
  if (!qos || !dds_qget_prop(qos, name, &value) || !value) return "";
  std::string text = printable_text(value, kMaxTopicNameBytes);
  dds_free(value);
  return text;
}

std::string entity_name(const dds_qos_t* qos) {
  char* value = nullptr;
  if (!qos || !dds_qget_entity_name(qos, &value) || !value) return "";
  std::string text = printable_text(value, kMaxTopicNameBytes);
  dds_free(value);
  return text;
}

// Cyclone DDS and Fast DDS each have properties of their own.
std::string describe(const dds_builtintopic_participant_t& participant) {
  const auto first = [&](std::initializer_list<const char*> names) {
    for (const char* name : names)
      if (std::string value = property(participant.qos, name); !value.empty()) return value;
    return std::string();
  };
  const std::string process = first({"__ProcessName"});
  const std::string pid = first({"__Pid", "fastdds.physical_data.process"});
  const std::string host = first({"__Hostname", "fastdds.physical_data.host"});
  std::string text = process.empty() ? entity_name(participant.qos) : process;
  if (!pid.empty()) text += (text.empty() ? "process " : ", process ") + pid;
  if (!host.empty()) text += (text.empty() ? "on " : " on ") + host;
  return text.empty() ? "participant " + guid_text(participant.key).substr(0, 24) : text;
}

// Calls take(sample, info) for each sample of a built-in topic.
template <typename Sample, typename Take>
void take_all(dds_entity_t reader, Take&& take) {
  constexpr size_t kBatch = 64;
  while (true) {
    std::array<void*, kBatch> samples{};
    std::array<dds_sample_info_t, kBatch> infos;
    const dds_return_t count = dds_take(reader, samples.data(), infos.data(), kBatch, kBatch);
    if (count <= 0) return;
    for (size_t i = 0; i < static_cast<size_t>(count); ++i)
      take(*static_cast<const Sample*>(samples[i]), infos[i]);
    dds_return_loan(reader, samples.data(), count);
  }
}

}  // namespace

Result<Discovery> Discovery::open(const Participant& participant) {
  Discovery discovery;
  discovery.own_ = participant.get();
  discovery.participants_ =
      Entity(dds_create_reader(participant.get(), DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr));
  discovery.publications_ =
      Entity(dds_create_reader(participant.get(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr));
  if (!discovery.participants_ || !discovery.publications_)
    return Error{"no readers of discovery (" + dds_text(discovery.publications_.get()) + ")"};
  dds_get_instance_handle(participant.get(), &discovery.own_handle_);
  return discovery;
}

void Discovery::update() {
  take_participants();
  take_publications();
}

void Discovery::take_participants() {
  take_all<dds_builtintopic_participant_t>(participants_.get(), [&](const auto& sample, const auto& info) {
    if (info.instance_state != DDS_IST_ALIVE || !info.valid_data) {
      names_.erase(info.instance_handle);
      return;
    }
    if (former_names_.size() > kMaxKnown) former_names_.clear();
    if (names_.size() < kMaxKnown)
      names_[info.instance_handle] = former_names_[info.instance_handle] = describe(sample);
  });
}

void Discovery::take_publications() {
  take_all<dds_builtintopic_endpoint_t>(publications_.get(), [&](const auto& sample, const auto& info) {
    if (info.instance_state != DDS_IST_ALIVE || !info.valid_data) {
      if (const auto gone = remotes_.find(info.instance_handle); gone != remotes_.end())
        gone->second.topic.clear();  // messages may still name it
      return;
    }
    if (sample.participant_instance_handle == own_handle_) return;
    if (remotes_.size() > kMaxKnown) {
      std::erase_if(remotes_, [](const auto& entry) { return entry.second.topic.empty(); });
      if (remotes_.size() > kMaxKnown) return;
    }
    remotes_[info.instance_handle] = {sample.participant_instance_handle,
                                      printable_text(ros_topic_name(sample.topic_name), kMaxTopicNameBytes),
                                      printable_text(ros_type_name(sample.type_name), kMaxTopicNameBytes),
                                      guid_text(sample.key), false};
  });
}

std::string Discovery::participant_text(dds_instance_handle_t participant) const {
  const auto found = former_names_.find(participant);
  return found == former_names_.end() ? "an unknown participant" : found->second;
}

std::string Discovery::publisher_text(dds_instance_handle_t publication) const {
  const auto found = remotes_.find(publication);
  if (found == remotes_.end()) return "an unknown publisher";
  return participant_text(found->second.participant) + " (publisher " + found->second.guid + ")";
}

std::string Discovery::summary() const {
  const size_t others = names_.size() - names_.count(own_handle_);
  if (others == 0) return "no other participant was discovered";
  std::set<std::string> topics;
  for (const auto& [handle, remote] : remotes_)
    if (!remote.topic.empty()) topics.insert(remote.topic + " (" + remote.type + ")");
  std::string text = counted(others, "participant");
  if (topics.empty()) return text + " without ROS topics";
  text += " with the topics ";
  size_t listed = 0;
  for (const std::string& topic : topics) {
    if (listed == kMaxListed) return text + " and " + std::to_string(topics.size() - listed) + " more";
    text += (listed++ == 0 ? "" : ", ") + topic;
  }
  return text;
}

std::vector<Discovery::News> Discovery::new_publishers(const std::string& topic,
                                                       const std::string& ros_type) {
  std::vector<News> news;
  for (auto& [handle, remote] : remotes_) {
    if (remote.is_reported || remote.topic != topic) continue;
    remote.is_reported = true;
    const std::string publisher = participant_text(remote.participant);
    if (remote.type == ros_type)
      news.push_back({topic + " is published by " + publisher, false});
    else
      news.push_back({topic + " has the type " + remote.type + " at " + publisher + ", not " + ros_type +
                          ": nothing is received from there",
                      true});
  }
  return news;
}

std::string new_incompatible_policy(dds_entity_t reader) {
  dds_requested_incompatible_qos_status_t status{};
  if (dds_get_requested_incompatible_qos_status(reader, &status) < 0 || status.total_count_change <= 0)
    return "";
  switch (status.last_policy_id) {
    case DDS_RELIABILITY_QOS_POLICY_ID:
      return "reliability";
    case DDS_DURABILITY_QOS_POLICY_ID:
      return "durability";
    default:
      return "quality of service policy " + std::to_string(status.last_policy_id);
  }
}

}  // namespace fire3dv::ros2
