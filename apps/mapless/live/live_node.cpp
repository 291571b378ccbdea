#include "live/live_node.hpp"

#include <chrono>
#include <exception>
#include <future>

#include "live/messages.hpp"
#include "terminal/stderr.hpp"
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace {

// How long an interrupt may wait.
constexpr dds_duration_t kLongestWait = DDS_MSECS(100);
// As diagnostic_aggregator expects it.
constexpr auto kDiagnosticsPeriod = std::chrono::seconds(1);
// Discovery takes one or two.
constexpr int kSecondsUntilHint = 3;

Time unix_now() {
  const auto since = std::chrono::system_clock::now().time_since_epoch();
  return Time::from_nanoseconds(std::chrono::duration_cast<std::chrono::nanoseconds>(since).count());
}

}  // namespace

LiveNode::LiveNode(const LiveNodeOptions& options)
    : options_(options),
      live_(options.live),
      participant_(options.domain),
      points_(participant_, options.live.topic, DdsQuality::sensor_data),
      labelled_(participant_, options.prefix + "points_labelled", DdsQuality::reliable),
      static_(participant_, options.prefix + "points_static", DdsQuality::reliable),
      moving_(participant_, options.prefix + "points_moving", DdsQuality::reliable),
      objects_(participant_, options.prefix + "objects", DdsQuality::reliable),
      markers_(participant_, options.prefix + "object_markers", DdsQuality::reliable),
      odometry_(participant_, options.prefix + "odometry", DdsQuality::reliable),
      processing_time_(participant_, options.prefix + "debug/processing_time_ms", DdsQuality::reliable),
      diagnostics_(participant_, "diagnostics", DdsQuality::reliable),
      reset_(participant_, options.prefix + "labeller/reset"),
      save_static_map_(participant_, options.prefix + "labeller/save_static_map"),
      static_map_(options.live) {
  if (options.live.needs_frames()) tf_static_.emplace(participant_, "tf_static", DdsQuality::transient_local);
  if (options.live.live.motion == LiveMotion::tf) tf_.emplace(participant_, "tf", DdsQuality::sensor_data);
  if (options.live.live.motion == LiveMotion::odometry)
    odometry_in_.emplace(participant_, options.odometry_topic, DdsQuality::sensor_data);
  if (options.live.live.use_imu) imu_.emplace(participant_, options.imu_topic, DdsQuality::sensor_data);
  if (options.live.live.use_wheel_odometry)
    wheels_.emplace(participant_, options.wheel_odometry_topic, DdsQuality::sensor_data);
  if (options.live.live.publish_tf) tf_out_.emplace(participant_, "tf", DdsQuality::reliable);
}

void LiveNode::run(const std::function<bool()>& stop) {
  std::atomic<bool> stop_reading = false;
  auto reading = std::async(std::launch::async, [&] { read_all(stop_reading); });
  struct EndReading {
    std::atomic<bool>& stop;
    ~EndReading() { stop = true; }  // the future waits for its end
  };
  auto next_diagnostics = std::chrono::steady_clock::now();
  {
    const EndReading end{stop_reading};
    while (!stop() && reading.wait_for(std::chrono::seconds(0)) == std::future_status::timeout) {
      live_.wait(Duration::from_nanoseconds(kLongestWait));
      label();
      if (std::chrono::steady_clock::now() < next_diagnostics) continue;
      next_diagnostics += kDiagnosticsPeriod;
      publish_diagnostics();
    }
  }
  reading.get();
  publish(live_.reset());
  publish_diagnostics();
}

void LiveNode::label() {
  if (reset_wanted_.exchange(false)) {
    publish(live_.reset());
    static_map_.clear();
  }
  const auto began = std::chrono::steady_clock::now();
  const std::vector<LiveOutput> outputs = live_.process();
  const std::chrono::duration<double, std::milli> processing = std::chrono::steady_clock::now() - began;
  publish(outputs);
  if (!outputs.empty() && processing_time_.has_readers()) processing_time_.write({processing.count()});
}

void LiveNode::read_all(const std::atomic<bool>& stop) {
  const dds_entity_t waitset = require_dds(dds_create_waitset(participant_.entity()), "waitset");
  const auto attach = [&](dds_entity_t reader) {
    require_dds(dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS), "waitset");
    require_dds(dds_waitset_attach(waitset, reader, 0), "waitset");
  };
  attach(points_.entity());
  if (tf_) attach(tf_->entity());
  if (tf_static_) attach(tf_static_->entity());
  if (odometry_in_) attach(odometry_in_->entity());
  if (imu_) attach(imu_->entity());
  if (wheels_) attach(wheels_->entity());
  attach(reset_.entity());
  attach(save_static_map_.entity());
  while (!stop) {
    require_dds(dds_waitset_wait(waitset, nullptr, 0, kLongestWait), "waitset");
    read_once();
  }
}

void LiveNode::read_once() {
  if (tf_static_) {
    while (const auto sample = tf_static_->take()) add_transforms(*sample->message, true);
  }
  if (tf_) {
    while (const auto sample = tf_->take()) add_transforms(*sample->message, false);
  }
  if (odometry_in_) {
    while (const auto sample = odometry_in_->take()) {
      const auto& message = *sample->message;
      live_.add_transform(options_.live.world_frame, message.child_frame_id, time_of(message.header.stamp),
                          transform_of(message.pose.pose), false);
    }
  }
  read_measurements();
  read_requests();
  while (const auto sample = points_.take()) live_.add_cloud(cloud_of(sample->message), sample->publisher);
}

// Before the clouds that they are measured during.
void LiveNode::read_measurements() {
  if (imu_) {
    while (const auto sample = imu_->take()) {
      const auto& message = *sample->message;
      live_.add_angular_velocity(message.header.frame_id, time_of(message.header.stamp),
                                 vector_of(message.angular_velocity));
    }
  }
  if (wheels_) {
    while (const auto sample = wheels_->take()) {
      const auto& message = *sample->message;
      live_.add_twist(message.child_frame_id, time_of(message.header.stamp),
                      vector_of(message.twist.twist.linear), vector_of(message.twist.twist.angular));
    }
  }
}

void LiveNode::read_requests() {
  while (const auto request = reset_.take()) {
    reset_wanted_ = true;
    reset_.reply(*request->message, {});
  }
  while (const auto request = save_static_map_.take()) {
    static_map_.save_aside(write_cloud_file, [this, request](const StaticMap::Answer& answer) {
      std::string message = answer.message;  // C has no const here
      save_static_map_.reply(*request->message, {0, 0, answer.success, message.data()});
    });
  }
}

void LiveNode::add_transforms(const tf2_msgs_msg_dds__TFMessage_& message, bool is_static) {
  for (std::uint32_t i = 0; i < message.transforms._length; ++i) {
    const auto& one = message.transforms._buffer[i];
    live_.add_transform(one.header.frame_id, one.child_frame_id, time_of(one.header.stamp),
                        transform_of(one.transform), is_static);
  }
}

// The map comes last: nobody waits for it.
void LiveNode::publish(const std::vector<LiveOutput>& outputs) {
  for (const LiveOutput& output : outputs) publish_one(output);
  for (const LiveOutput& output : outputs) static_map_.add(output);
}

// Nothing is made that nobody reads. The labels first, then what is small.
void LiveNode::publish_one(const LiveOutput& output) {
  if (labelled_.has_readers()) labelled_.write(cloud_message(labelled_cloud(output)).message);
  publish_odometry(output);
  if (objects_.has_readers()) objects_.write(objects_message(output).message);
  if (markers_.has_readers()) markers_.write(markers_message(output).message);
  if (moving_.has_readers())
    moving_.write(cloud_message(selected_cloud(output, PointMotion::moving)).message);
  if (static_.has_readers()) static_.write(cloud_message(selected_cloud(output, PointMotion::still)).message);
}

void LiveNode::publish_odometry(const LiveOutput& output) {
  const auto odometry = live_odometry(output);
  if (!odometry) return;
  if (odometry_.has_readers())
    odometry_.write(odometry_message(*odometry, output.world_frame, output.body_frame).message);
  if (tf_out_)
    tf_out_->write(transforms_message(live_transforms(output, options_.live.live.invert_odom_tf)).message);
}

void LiveNode::publish_diagnostics() {
  LiveDiagnostics diagnostics = live_.diagnostics();
  if (++diagnostics_count_ > kSecondsUntilHint && !diagnostics.has_clouds) {
    diagnostics.message = why_no_cloud(options_.live.topic, published_topics(participant_));
    if (diagnostics_count_ == kSecondsUntilHint + 1)
      say("mapless: domain {}: {}\n", options_.domain, diagnostics.message);
  }
  for (const LiveEvent& event : live_.take_events()) {
    static constexpr const char* kLevels[] = {"", "warning: ", "error: "};
    say("mapless: {}{}\n", kLevels[static_cast<int>(event.level)], event.text);
  }
  if (diagnostics_.has_readers()) diagnostics_.write(diagnostics_message(diagnostics, unix_now()).message);
}

}  // namespace mapless::app
