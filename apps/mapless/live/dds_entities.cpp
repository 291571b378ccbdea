#include "live/dds_entities.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <string_view>
#include <utility>

#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace {

// As many turns as a process that is held up for half a second misses.
constexpr std::int32_t kDepth = 5;
constexpr std::int32_t kDepthOfStatic = 100;  // as tf2_ros has it: each broadcaster sends its own
// As rmw_cyclonedds waits for the reader of replies.
constexpr int kMostTries = 10;
constexpr dds_duration_t kTryPeriod = DDS_MSECS(10);
// A tenth of a turn: labels for the others are more urgent than a slow reader.
constexpr dds_duration_t kLongestBlocking = DDS_MSECS(10);

using Qos = std::unique_ptr<dds_qos_t, void (*)(dds_qos_t*)>;

Qos qos_of(DdsQuality quality, const std::string& hash) {
  Qos qos(dds_create_qos(), dds_delete_qos);
  const bool latched = quality == DdsQuality::transient_local;
  dds_qset_reliability(
      qos.get(), quality == DdsQuality::sensor_data ? DDS_RELIABILITY_BEST_EFFORT : DDS_RELIABILITY_RELIABLE,
      kLongestBlocking);
  dds_qset_durability(qos.get(), latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, latched ? kDepthOfStatic : kDepth);
  if (!hash.empty()) {
    const std::string data = "typehash=" + hash + ";";
    dds_qset_userdata(qos.get(), data.data(), data.size());
  }
  return qos;
}

dds_entity_t make_topic(const DdsParticipant& participant, const std::string& topic,
                        const dds_topic_descriptor_t* type) {
  return require_dds(dds_create_topic(participant.entity(), type, topic.c_str(), nullptr, nullptr),
                     "topic " + topic);
}

// "sensor_msgs/msg/PointCloud2" of "sensor_msgs::msg::dds_::PointCloud2_".
std::string ros_type(std::string name) {
  for (const auto& [part, with] : {std::pair("dds_::", ""), std::pair("::", "/")}) {
    for (std::size_t at = name.find(part); at != std::string::npos; at = name.find(part))
      name.replace(at, std::strlen(part), with);
  }
  if (name.ends_with('_')) name.pop_back();
  return name;
}

// Of all topics of a robot at once.
constexpr std::uint32_t kMostPublications = 1000;

}  // namespace

dds_return_t require_dds(dds_return_t result, const std::string& what) {
  if (result >= 0) return result;
  throw Error({"Cyclone DDS", what, "", dds_strretcode(-result),
               "see CYCLONEDDS_URI, ROS_DOMAIN_ID and the network interfaces"});
}

DdsParticipant::DdsParticipant(std::uint32_t domain)
    : entity_(require_dds(dds_create_participant(domain, nullptr, nullptr), "participant")) {}
DdsParticipant::~DdsParticipant() { dds_delete(entity_); }

std::string dds_topic(const std::string& name, DdsChannel channel) {
  const std::string relative = name.starts_with('/') ? name.substr(1) : name;
  if (channel == DdsChannel::request) return "rq/" + relative + "Request";
  if (channel == DdsChannel::reply) return "rr/" + relative + "Reply";
  return "rt/" + relative;
}

dds_entity_t make_reader(const DdsParticipant& participant, const std::string& topic,
                         const dds_topic_descriptor_t* type, const std::string& hash, DdsQuality quality) {
  const dds_entity_t entity = make_topic(participant, topic, type);
  const Qos qos = qos_of(quality, hash);
  return require_dds(dds_create_reader(participant.entity(), entity, qos.get(), nullptr), "topic " + topic);
}

dds_entity_t make_writer(const DdsParticipant& participant, const std::string& topic,
                         const dds_topic_descriptor_t* type, const std::string& hash, DdsQuality quality) {
  const dds_entity_t entity = make_topic(participant, topic, type);
  const Qos qos = qos_of(quality, hash);
  return require_dds(dds_create_writer(participant.entity(), entity, qos.get(), nullptr), "topic " + topic);
}

bool has_readers(dds_entity_t writer) {
  dds_publication_matched_status_t status = {};
  require_dds(dds_get_publication_matched_status(writer, &status), "readers");
  return status.current_count > 0;
}

void wait_for_clients(dds_entity_t requests, dds_entity_t replies) {
  for (int tries = 0; tries < kMostTries; ++tries) {
    dds_subscription_matched_status_t writers = {};
    dds_publication_matched_status_t readers = {};
    require_dds(dds_get_subscription_matched_status(requests, &writers), "clients");
    require_dds(dds_get_publication_matched_status(replies, &readers), "clients");
    if (readers.current_count >= writers.current_count) return;
    dds_sleepfor(kTryPeriod);
  }
}

std::vector<PublishedTopic> published_topics(const DdsParticipant& participant) {
  const dds_entity_t reader = require_dds(
      dds_create_reader(participant.entity(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr),
      "discovery");
  std::vector<void*> samples(kMostPublications, nullptr);
  std::vector<dds_sample_info_t> infos(kMostPublications);
  const dds_return_t count =
      dds_read(reader, samples.data(), infos.data(), kMostPublications, kMostPublications);
  dds_guid_t own = {};
  dds_get_guid(participant.entity(), &own);
  std::vector<PublishedTopic> topics;
  for (dds_return_t i = 0; i < count; ++i) {
    const auto& found =
        *static_cast<const dds_builtintopic_endpoint_t*>(samples[static_cast<std::size_t>(i)]);
    const std::string_view name = found.topic_name;
    const bool is_own = std::equal(std::begin(own.v), std::end(own.v), std::begin(found.participant_key.v));
    const bool is_alive = infos[static_cast<std::size_t>(i)].instance_state == DDS_ALIVE_INSTANCE_STATE;
    if (is_alive && !is_own && name.starts_with("rt/"))
      topics.push_back({std::string(name.substr(3)), ros_type(found.type_name)});
  }
  if (count > 0) dds_return_loan(reader, samples.data(), count);
  dds_delete(reader);
  require_dds(count, "discovery");
  return topics;
}

}  // namespace mapless::app
