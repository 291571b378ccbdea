#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <mapless/core/se3.hpp>
#include <mapless/core/time.hpp>
#include <mapless/trajectory/trajectory.hpp>

namespace mapless::inline v1 {

/// The transforms of the last seconds, as tf has them: a tree of frames, each with one parent. Not
/// thread-safe.
class TransformBuffer {
 public:
  /// Transforms that are not rigid or not finite, and those out of order, are ignored. Stamps that jump back
  /// by more than a second begin the edge anew.
  void add(const std::string& parent, const std::string& child, Time time, const SE3& T_parent_child,
           bool is_static);

  struct Lookup {
    std::shared_ptr<const Trajectory> trajectory;  ///< T_v0 over [begin, end]; null: not known
    std::string reason;                            ///< why it is not known
    bool over = false;  ///< it will never be known: the transforms begin after `begin`
  };
  /// The trajectory of `frame` in the world `world`.
  [[nodiscard]] Lookup find(const std::string& frame, const std::string& world, Time begin, Time end) const;
  /// T_ab of two frames that static transforms connect, by any common ancestor; none where they do not.
  [[nodiscard]] std::optional<SE3> fixed(const std::string& a, const std::string& b) const;

 private:
  struct Edge {
    std::string parent;
    bool is_static = false;
    std::deque<TimedPose> poses;  // T_v0: child from parent

    [[nodiscard]] std::shared_ptr<const Trajectory> trajectory(Time begin, Time end) const;
  };

  [[nodiscard]] std::map<std::string, SE3> fixed_ancestors(const std::string& frame) const;
  [[nodiscard]] std::vector<const Edge*> chain(const std::string& frame, const std::string& world) const;
  [[nodiscard]] std::string known_edges() const;

  std::map<std::string, Edge> edges_;  // by child
};

}  // namespace mapless
