#include "benchmark/speed/yardstick.hpp"

#include <nanoflann.hpp>

namespace mapless::app {
namespace {

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

}  // namespace

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
