#pragma once

#include <vector>

#include <mapless/lidar/lidar_model.hpp>

namespace mapless::inline v1 {

/// The beams of a sensor in its hub frame, in single precision, arranged to find the nearest beams above and
/// below a point.
struct BeamFan {
  explicit BeamFan(const LidarModel& model);

  struct alignas(16) Beam {  // of one laser; the first four members and the next four are read at once
    float cosine, sine;      // of its elevation
    float ahead_m, left_m;   // its origin in the hub, turned by the azimuth offset
    float up_m;
    float offset_columns;  // columns by which it points somewhere later than the hub's x axis
    float spacing_rad;     // elevation to the farther of its neighbours
    int laser;
    float azimuth_cosine, azimuth_sine;  // of its offset
  };
  /// Lasers that start at one height, by elevation: within a bank the beams above and below a point are
  /// neighbours.
  struct Bank {
    float height_m;
    float centre_x_m, centre_z_m;  // the point of the hub nearest to all its beams (least squares)
    std::vector<Beam> beams;       // with one far below all and one far above, of no laser
    std::vector<float> slopes;     // tangents of their elevations, and infinity
    std::vector<int> at_least;     // for equal steps of the slope: a lower bound of the lasers below
    float steps_per_slope;
    int offset;  // of its beams in `banked`
    void centre();
    /// Adds the last beam and slope, and the table.
    void close();
    /// Number of lasers with a slope below `slope`.
    [[nodiscard]] int below(float slope) const;
  };

  float columns_per_rad;    ///< of the hub's turn; below 0 where it turns clockwise
  std::vector<Beam> beams;  ///< of each laser
  std::vector<Bank> banks;
  std::vector<Beam> banked;  ///< those of all banks, one bank after another
  struct Turn {
    double cosine, sine;
  };
  std::vector<Turn> turns;  ///< turn_at of each column of the model
  /// Turn of the hub at a column.
  [[nodiscard]] static Turn turn_at(const LidarModel& model, int column);
};

}  // namespace mapless
