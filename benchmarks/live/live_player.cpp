#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "live/dds_entities.hpp"
#include "live/messages.hpp"
#include <mapless/io/dataset.hpp>

// Publishes the scans of a recording at the pace of a sensor, as a Velodyne driver packs them, and prints how
// long after the arrival of the newest cloud that they need the labels of a cloud came back, as a subscriber
// sees it:
//
//     live_player RECORDING [CLOUDS [RATE_HZ [NEWER]]]
//
// CLOUDS: how many in all (default: the recording once); the recording begins again after a gap of two
// seconds, as a sensor that was unplugged. RATE_HZ: 10. NEWER: clouds that the labels of one wait for; 1,
// with --causal 0. Each scan is read while the one before it is due.

namespace mapless::app {
namespace {

using Clock = std::chrono::steady_clock;
using CloudData = sensor_msgs_msg_dds__PointCloud2_;

constexpr std::int64_t kFirstStamp_ns = 1'700'000'000'000'000'000;
constexpr double kGap_s = 2;
constexpr auto kLastLabels = std::chrono::seconds(3);
constexpr std::uint32_t kPointStep = 22;
constexpr std::uint8_t kFloat32 = 7, kUint16 = 4;

template <class Value>
void put(std::vector<std::uint8_t>& bytes, std::size_t at, Value value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

/// x, y, z, intensity, ring, time of every record; x, y, z are NaN without a return.
std::shared_ptr<std::vector<std::uint8_t>> packed(const LidarScan& scan) {
  auto bytes = std::make_shared<std::vector<std::uint8_t>>(scan.input_size * kPointStep, std::uint8_t{0});
  const std::size_t per_laser = scan.input_size / scan.model->lasers.size();
  for (std::size_t i = 0; i < scan.input_size; ++i) {
    for (const std::size_t axis : {0U, 1U, 2U})
      put(*bytes, kPointStep * i + 4 * axis, std::numeric_limits<float>::quiet_NaN());
    put(*bytes, kPointStep * i + 16, static_cast<std::uint16_t>(i / per_laser));
  }
  for (const LidarReturn& r : scan.returns) {
    const std::size_t at = kPointStep * r.input_index;
    for (const int axis : {0, 1, 2}) put(*bytes, at + 4 * static_cast<std::size_t>(axis), r.position_v[axis]);
    put(*bytes, at + 16, static_cast<std::uint16_t>(r.laser));
    put(*bytes, at + 18, static_cast<float>(1e-9 * r.time_ns));
  }
  return bytes;
}

PointCloud2 cloud_of(const LidarScan& scan) {
  const auto bytes = packed(scan);
  PointCloud2 out;
  out.owner = bytes;
  out.view.frame_id = "lidar";
  out.view.width = static_cast<std::uint32_t>(scan.input_size);
  out.view.fields = {{"x", 0, kFloat32, 1},          {"y", 4, kFloat32, 1},    {"z", 8, kFloat32, 1},
                     {"intensity", 12, kFloat32, 1}, {"ring", 16, kUint16, 1}, {"time", 18, kFloat32, 1}};
  out.view.point_step = kPointStep;
  out.view.row_step = kPointStep * out.view.width;
  out.view.data = *bytes;
  return out;
}

/// When clouds were written and their labels came, by their stamps; two threads use it.
class Times {
 public:
  void wrote(std::int64_t stamp_ns) { add(written_, stamp_ns); }
  void labelled(std::int64_t stamp_ns) { add(labelled_, stamp_ns); }

  /// From the arrival of the cloud `newer` after it to the labels of each cloud [ms], sorted.
  [[nodiscard]] std::vector<double> latencies_ms(int newer) const {
    std::vector<double> out;
    for (auto it = written_.begin(); it != written_.end(); ++it) {
      const auto label = labelled_.find(it->first);
      auto needed = it;
      for (int k = 0; k < newer && needed != written_.end(); ++k) ++needed;
      if (label == labelled_.end() || needed == written_.end()) continue;
      const std::chrono::duration<double, std::milli> latency = label->second - needed->second;
      out.push_back(std::max(0.0, latency.count()));  // of the last cloud before a gap: none newer is awaited
    }
    std::sort(out.begin(), out.end());
    return out;
  }
  [[nodiscard]] std::size_t written() const { return written_.size(); }
  [[nodiscard]] std::size_t labelled() const { return labelled_.size(); }
  [[nodiscard]] double first_labels_s() const {
    if (labelled_.empty()) return std::numeric_limits<double>::quiet_NaN();
    const std::chrono::duration<double> after = labelled_.begin()->second - written_.begin()->second;
    return after.count();
  }

 private:
  void add(std::map<std::int64_t, Clock::time_point>& times, std::int64_t stamp_ns) {
    const auto now = Clock::now();
    const std::lock_guard lock(mutex_);
    times.emplace(stamp_ns, now);
  }
  std::mutex mutex_;
  std::map<std::int64_t, Clock::time_point> written_, labelled_;
};

void read_labels(const DdsReader<CloudData>& reader, Times& times, const std::atomic<bool>& stop) {
  while (!stop) {
    while (const auto sample = reader.take())
      times.labelled(time_of(sample->message->header.stamp).nanoseconds());
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

struct Plan {
  std::size_t clouds = 0;
  double rate_hz = 10;
  int newer = 1;
};

void play(const Dataset& recording, const Plan& plan, const DdsWriter<CloudData>& writer, Times& times) {
  const auto start = Clock::now();
  for (std::size_t k = 0; k < plan.clouds; ++k) {
    const double at_s =
        static_cast<double>(k) / plan.rate_hz + kGap_s * static_cast<double>(k / recording.size());
    PointCloud2 cloud = cloud_of(recording.read(k % recording.size()));
    cloud.view.stamp = Time::from_nanoseconds(kFirstStamp_ns + std::llround(1e9 * at_s));
    const CloudMessage message = cloud_message(cloud);
    std::this_thread::sleep_until(
        start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(at_s)));
    times.wrote(cloud.view.stamp.nanoseconds());
    writer.write(message.message);
  }
}

void print(const Times& times, int newer) {
  const std::vector<double> all = times.latencies_ms(newer);
  fmt::print("{} of {} clouds labelled, the first labels {:.2f} s after the first cloud\n", times.labelled(),
             times.written(), times.first_labels_s());
  if (all.empty()) return;
  const auto of = [&](double share) {
    return all[static_cast<std::size_t>(share * static_cast<double>(all.size() - 1))];
  };
  fmt::print(
      "latency: median {:.1f} ms, 95 % {:.1f} ms, 99 % {:.1f} ms, 99.9 % {:.1f} ms, largest {:.1f} ms\n",
      of(0.5), of(0.95), of(0.99), of(0.999), all.back());
}

int run(const std::vector<std::string>& arguments) {
  const auto recording = open_dataset(arguments.at(0));
  Plan plan{recording->size(), 10, 1};
  if (arguments.size() > 1) plan.clouds = std::stoul(arguments[1]);
  if (arguments.size() > 2) plan.rate_hz = std::stod(arguments[2]);
  if (arguments.size() > 3) plan.newer = std::stoi(arguments[3]);

  const char* domain = std::getenv("ROS_DOMAIN_ID");
  const DdsParticipant participant(domain == nullptr ? 0 : static_cast<std::uint32_t>(std::stoul(domain)));
  const DdsReader<CloudData> reader(participant, "points_labelled", DdsQuality::reliable);
  const DdsWriter<CloudData> writer(participant, "points", DdsQuality::reliable);
  while (!writer.has_readers()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  std::this_thread::sleep_for(std::chrono::seconds(1));  // until the node sees this reader
  Times times;
  std::atomic<bool> stop = false;
  std::thread labels([&] { read_labels(reader, times, stop); });
  play(*recording, plan, writer, times);
  std::this_thread::sleep_for(kLastLabels);
  stop = true;
  labels.join();
  print(times, plan.newer);
  return times.labelled() == times.written() ? 0 : 1;
}

}  // namespace
}  // namespace mapless::app

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: live_player RECORDING [CLOUDS [RATE_HZ [NEWER]]]\n");
    return 2;
  }
  try {
    return mapless::app::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "live_player: {}\n", error.what());
    return 1;
  }
}
