#include "benchmark/speed/speed_drive.hpp"

#include <charconv>
#include <nanoflann.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <mapless/core/errors.hpp>

namespace mapless::app {
namespace {

constexpr int kMostColumns = 8192;

struct CloudAdaptor {
  const std::vector<Eigen::Vector3d>& points;
  [[nodiscard]] std::size_t kdtree_get_point_count() const { return points.size(); }
  [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t d) const {
    return points[i][static_cast<Eigen::Index>(d)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

std::optional<int> whole(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

}  // namespace

// All lasers of an OS1 fire at once, so that its columns can be as many as one likes; those of the others
// fire in turn, which takes its time.
LidarModel sensor_of(const std::string& name) {
  const std::size_t x = name.starts_with("OS1-") ? name.rfind('x') : std::string::npos;
  if (x == std::string::npos) return named_model(name);
  const auto columns = whole(std::string_view(name).substr(x + 1));
  if (!columns || *columns < 1 || *columns > kMostColumns) {
    throw ParameterError({"--sensors", "columns", name, fmt::format("must be 1 to {}", kMostColumns),
                          "give for example OS1-128x2048"});
  }
  LidarModel model = named_model(name.substr(0, x));
  model.name = name;
  model.columns = *columns;
  return model;
}

SpeedDrive::SpeedDrive(const std::string& scene, double duration_s, std::uint64_t seed,
                       const std::string& sensor)
    : scene_(make_scene(scene, {seed, duration_s, true})),
      model_(std::make_shared<const LidarModel>(sensor_of(sensor))),
      trajectory_(std::make_shared<const SampledTrajectory>(scene_.poses, Duration(), "scene")),
      world_(scene_.world),
      sensor_(model_, trajectory_, world_, {0.02, true, seed}) {}

std::shared_ptr<const LidarScan> SpeedDrive::scan(int number) { return sensor_.lidar_scan(number); }

BusyTime yardstick(const std::vector<Eigen::Vector3d>& of, const std::vector<Eigen::Vector3d>& queries) {
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, CloudAdaptor>,
                                                   CloudAdaptor, 3>;
  return busy_time_of([&] {
    const CloudAdaptor cloud{of};
    Tree tree(3, cloud);
    tree.buildIndex();
    for (const Eigen::Vector3d& q : queries) {
      unsigned index = 0;
      double distance2 = 0;
      tree.knnSearch(q.data(), 1, &index, &distance2);
    }
  });
}

}  // namespace mapless::app
