#include "live/live.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <tbb/global_control.h>

#include "live/live_node.hpp"
#include "options/option_checks.hpp"
#include "options/parameter_options.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/stderr.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace {

struct LiveVerbOptions {
  LiveNodeOptions node;
  ParameterOptions parameters;
  std::map<std::string, std::string> live;  // LiveParameters by key
  std::optional<std::size_t> threads;
};

// Participants find one another within one or two seconds.
constexpr int kLongestDiscovery_ms = 2000, kPoll_ms = 50;

// Domains above 232 have no UDP ports.
constexpr unsigned long kMostDomain = 232;

std::uint32_t domain_of_environment() {
  const char* text = std::getenv("ROS_DOMAIN_ID");
  if (text == nullptr || *text == '\0') return 0;
  char* end = nullptr;
  const unsigned long domain = std::strtoul(text, &end, 10);
  if (*end == '\0' && *text != '-' && domain <= kMostDomain) return static_cast<std::uint32_t>(domain);
  throw ParameterError({"environment", "ROS_DOMAIN_ID", text, "not a whole number from 0 to 232",
                        "set it as for the other nodes"});
}

// Without a name: `points`, or the only topic of clouds that is published.
std::string find_topic(std::uint32_t domain) {
  const DdsParticipant participant(domain);
  const std::string usual = LiveOptions().topic;
  std::vector<std::string> found;
  for (int waited = 0; waited < kLongestDiscovery_ms && !InterruptGuard::requested(); waited += kPoll_ms) {
    std::this_thread::sleep_for(std::chrono::milliseconds(kPoll_ms));
    found = cloud_topics(published_topics(participant));
    if (std::find(found.begin(), found.end(), usual) != found.end()) return usual;
  }
  if (found.size() > 1)
    throw ParameterError({fmt::format("domain {}", domain), "topic",
                          fmt::format("{}", fmt::join(found, ", ")), "several carry clouds",
                          "choose one by --points"});
  return found.empty() ? usual : found.front();
}

std::string flag_of(std::string key) {
  for (char& c : key) c = c == '_' ? '-' : c;
  return "--" + key;
}

// One flag for each LiveParameters, from its declaration.
void add_live_parameters(CLI::App& verb, LiveVerbOptions& options) {
  LiveParameters defaults;
  for (const ParameterReference& parameter : parameter_references(defaults)) {
    std::string& text = options.live[parameter.key];
    const std::string flag = flag_of(parameter.key);
    if (std::holds_alternative<bool*>(parameter.value)) {
      verb.add_flag_callback(
          flag, [&text] { text = "true"; }, std::string(parameter.help));
    } else if (std::holds_alternative<ChoiceReference>(parameter.value)) {
      verb.add_option(flag, text, fmt::format("{} [default {}]", parameter.help, parameter.text()));
    } else {
      verb.add_option(flag, text,
                      fmt::format("{} [{}, {} to {}, default {}]", parameter.help, parameter.unit,
                                  parameter.min, parameter.max, parameter.text()));
    }
  }
}

void say_end(const LiveDiagnostics& diagnostics) {
  std::string line;
  for (const auto& [key, value] : diagnostics.values)
    line += fmt::format("{}{} {}", line.empty() ? "" : ", ", key, value);
  say("mapless: ended: {}\n", line);
}

int live(LiveVerbOptions options) {
  std::optional<tbb::global_control> threads;
  if (options.threads) threads.emplace(tbb::global_control::max_allowed_parallelism, *options.threads);
  LiveNodeOptions& node = options.node;
  node.domain = domain_of_environment();
  node.live.detector = {options.parameters.chosen(), options.parameters.odometry(), options.threads != 1};
  const auto references = parameter_references(node.live.live);
  for (const auto& [key, text] : options.live) {
    if (!text.empty()) assign_parameter(references, key, text, flag_of(key));
  }
  if (!node.live.sensor_name.empty()) node.live.sensor = model_from_name_or_file(node.live.sensor_name);
  if (!node.live.static_map_file.empty()) (void)cloud_format_of(node.live.static_map_file);
  const InterruptGuard interrupt;
  if (node.live.topic.empty()) node.live.topic = find_topic(node.domain);
  LiveNode running(node);
  say("mapless: reads topic {} in domain {}, writes {}points_labelled\n", node.live.topic, node.domain,
      node.prefix);
  running.run(InterruptGuard::requested);
  say_end(running.diagnostics());
  return kSuccess;
}

}  // namespace

void add_live(CLI::App& app, int& exit_code) {
  auto* verb = app.add_subcommand(
      "live",
      "Label the clouds of a running lidar, as a node of ROS 2 (over DDS, without ROS): topic points in; "
      "points_labelled, points_static, points_moving, objects, object_markers, odometry, diagnostics out; "
      "services labeller/reset and labeller/save_static_map");
  const auto options = std::make_shared<LiveVerbOptions>();
  LiveNodeOptions& node = options->node;
  node.live.topic.clear();
  verb->add_option("--points", node.live.topic,
                   "topic of the clouds, sensor_msgs/PointCloud2 (default: points, or the only topic of "
                   "clouds that is published)")
      ->check(topic_name());
  for (const LiveSetting& setting : live_settings(node.live)) {
    verb->add_option(flag_of(std::string(setting.name)), *setting.value, std::string(setting.help))
        ->capture_default_str();
  }
  verb->add_option("--odometry-topic", node.odometry_topic, "topic of nav_msgs/Odometry that is read")
      ->check(topic_name())
      ->capture_default_str();
  verb->add_option("--imu-topic", node.imu_topic, "topic of sensor_msgs/Imu, for --use-imu")
      ->check(topic_name())
      ->capture_default_str();
  verb->add_option("--wheel-odometry-topic", node.wheel_odometry_topic,
                   "topic of nav_msgs/Odometry whose twist is read, for --use-wheel-odometry")
      ->check(topic_name())
      ->capture_default_str();
  verb->add_option("--prefix", node.prefix,
                   "before the names of the topics written and of the services, such as mapless/")
      ->check(topic_prefix());
  add_live_parameters(*verb, *options);
  add_parameter_options(*verb, options->parameters);
  verb->add_flag("--causal", options->parameters.causal,
                 "label each cloud at once, without evidence from the next (forward_gap = 0)");
  verb->add_option("--threads", options->threads, "number of threads (default: all cores)")
      ->check(CLI::Range(1, 1024));
  verb->footer(
      "ROS_DOMAIN_ID and CYCLONEDDS_URI are read as by ROS 2. SIGINT or SIGTERM ends it (exit code 0). "
      "docs/ros2.md has the topics and the settings of the network.");
  verb->callback([options, &exit_code] { exit_code = live(*options); });
}

}  // namespace mapless::app
