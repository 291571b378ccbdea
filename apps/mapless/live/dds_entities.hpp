#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <dds/dds.h>

#include "ros2_messages.h"
#include <mapless/live/live_options.hpp>

namespace mapless::app {

/// Throws Error naming `what` where `result` is a code of failure; else returns it.
dds_return_t require_dds(dds_return_t result, const std::string& what);

/// Descriptor, and hash of the definition in ROS 2 (REP 2016), of each message.
template <class Message>
struct DdsType;

#define MAPLESS_DDS_TYPE(message, rihs)                                           \
  template <>                                                                     \
  struct DdsType<message> {                                                       \
    static const dds_topic_descriptor_t* descriptor() { return &message##_desc; } \
    static constexpr const char* kHash = "RIHS01_" rihs;                          \
  }
MAPLESS_DDS_TYPE(sensor_msgs_msg_dds__PointCloud2_,
                 "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5");
MAPLESS_DDS_TYPE(std_msgs_msg_dds__Float64_,
                 "705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a");
MAPLESS_DDS_TYPE(nav_msgs_msg_dds__Odometry_,
                 "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0");
MAPLESS_DDS_TYPE(sensor_msgs_msg_dds__Imu_,
                 "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b");
MAPLESS_DDS_TYPE(tf2_msgs_msg_dds__TFMessage_,
                 "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087");
MAPLESS_DDS_TYPE(diagnostic_msgs_msg_dds__DiagnosticArray_,
                 "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e");
MAPLESS_DDS_TYPE(visualization_msgs_msg_dds__MarkerArray_,
                 "86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf");
MAPLESS_DDS_TYPE(vision_msgs_msg_dds__Detection3DArray_, "");
MAPLESS_DDS_TYPE(std_srvs_srv_dds__Empty_Request_, "");
MAPLESS_DDS_TYPE(std_srvs_srv_dds__Empty_Response_, "");
MAPLESS_DDS_TYPE(std_srvs_srv_dds__Trigger_Request_, "");
MAPLESS_DDS_TYPE(std_srvs_srv_dds__Trigger_Response_, "");
#undef MAPLESS_DDS_TYPE

/// Profiles of quality of service, as ROS 2 names them.
enum class DdsQuality {
  sensor_data,      ///< best effort, volatile: reads from reliable publishers too
  reliable,         ///< reliable, volatile
  transient_local,  ///< reliable, and what was published before is sent to who comes later
};

/// A participant of a domain. CYCLONEDDS_URI configures it.
class DdsParticipant {
 public:
  explicit DdsParticipant(std::uint32_t domain);
  ~DdsParticipant();
  DdsParticipant(const DdsParticipant&) = delete;
  DdsParticipant& operator=(const DdsParticipant&) = delete;
  [[nodiscard]] dds_entity_t entity() const { return entity_; }

 private:
  dds_entity_t entity_;
};

/// What carries a message of ROS 2. A service has one topic of DDS for its requests and one for its replies.
enum class DdsChannel { topic, request, reply };
/// The topic of DDS for the topic or service `name` of ROS 2.
[[nodiscard]] std::string dds_topic(const std::string& name, DdsChannel channel);

/// `topic` of DDS, without type; the entities end with the participant.
[[nodiscard]] dds_entity_t make_reader(const DdsParticipant& participant, const std::string& topic,
                                       const dds_topic_descriptor_t* type, const std::string& hash,
                                       DdsQuality quality);
[[nodiscard]] dds_entity_t make_writer(const DdsParticipant& participant, const std::string& topic,
                                       const dds_topic_descriptor_t* type, const std::string& hash,
                                       DdsQuality quality);
[[nodiscard]] bool has_readers(dds_entity_t writer);

/// The topics of ROS 2 that others publish, as far as they are discovered.
[[nodiscard]] std::vector<PublishedTopic> published_topics(const DdsParticipant& participant);

template <class Message>
class DdsReader {
 public:
  struct Sample {
    std::shared_ptr<const Message> message;
    std::uint64_t publisher;
  };

  /// `name`: of the topic or service of ROS 2.
  DdsReader(const DdsParticipant& participant, const std::string& name, DdsQuality quality,
            DdsChannel channel = DdsChannel::topic)
      : reader_(make_reader(participant, dds_topic(name, channel), DdsType<Message>::descriptor(),
                            DdsType<Message>::kHash, quality)) {}
  [[nodiscard]] dds_entity_t entity() const { return reader_; }

  /// The next message, read into memory of its own; none where none waits.
  [[nodiscard]] std::optional<Sample> take() const {
    for (;;) {
      const std::shared_ptr<Message> message(
          static_cast<Message*>(dds_alloc(sizeof(Message))),
          [](Message* m) { dds_sample_free(m, DdsType<Message>::descriptor(), DDS_FREE_ALL); });
      void* sample = message.get();
      dds_sample_info_t info = {};
      if (require_dds(dds_take(reader_, &sample, &info, 1, 1), "reading") == 0) return std::nullopt;
      if (info.valid_data) return Sample{message, info.publication_handle};
    }
  }

 private:
  dds_entity_t reader_;
};

template <class Message>
class DdsWriter {
 public:
  /// `name`: of the topic or service of ROS 2.
  DdsWriter(const DdsParticipant& participant, const std::string& name, DdsQuality quality,
            DdsChannel channel = DdsChannel::topic)
      : writer_(make_writer(participant, dds_topic(name, channel), DdsType<Message>::descriptor(),
                            DdsType<Message>::kHash, quality)) {}
  [[nodiscard]] dds_entity_t entity() const { return writer_; }
  [[nodiscard]] bool has_readers() const { return app::has_readers(writer_); }
  /// A reader that is too slow loses messages; the writer does not wait for it.
  void write(const Message& message) const {
    const dds_return_t result = dds_write(writer_, &message);
    if (result != DDS_RETCODE_TIMEOUT) require_dds(result, "writing");
  }

 private:
  dds_entity_t writer_;
};

/// Waits until as many clients read `replies` as send `requests`, at most 100 ms, as rmw_cyclonedds does: a
/// reply that is written before its client's reader is found is lost.
void wait_for_clients(dds_entity_t requests, dds_entity_t replies);

/// A service of ROS 2, for clients on Cyclone DDS: other middlewares send the number of a request outside its
/// message.
template <class Request, class Response>
class DdsService {
 public:
  DdsService(const DdsParticipant& participant, const std::string& name)
      : requests_(participant, name, DdsQuality::reliable, DdsChannel::request),
        replies_(participant, name, DdsQuality::reliable, DdsChannel::reply) {}
  [[nodiscard]] dds_entity_t entity() const { return requests_.entity(); }
  /// The next request; none where none waits.
  [[nodiscard]] auto take() const { return requests_.take(); }
  void reply(const Request& request, Response response) const {
    response.client = request.client;
    response.number = request.number;
    wait_for_clients(requests_.entity(), replies_.entity());
    replies_.write(response);
  }

 private:
  DdsReader<Request> requests_;
  DdsWriter<Response> replies_;
};

}  // namespace mapless::app
