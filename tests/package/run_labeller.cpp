// A round room of 20 m radius in which a box of half a metre to a side goes round at 8 m: what moves is the
// box.
#include <cmath>
#include <cstdio>
#include <numbers>

#include "labeller.hpp"
#include <mapless/core/errors.hpp>

namespace {

constexpr int kTurns = 30;
constexpr double kTurn_s = 0.1;
constexpr double kRoom_m = 20, kBox_m = 8, kBoxWidth_m = 1.2, kBoxSpeed_mps = 4;

double column_angle(const Labeller& labeller, int column) {
  return 2 * std::numbers::pi * column / labeller.columns();
}

bool on_box(const Labeller& labeller, int turn, int column) {
  const double box = 1 + kBoxSpeed_mps / kBox_m * kTurn_s * turn;
  return std::abs(column_angle(labeller, column) - box) < kBoxWidth_m / kBox_m / 2;
}

bool exception_is_caught_by_its_type() {
  try {
    Labeller labeller(-1);
  } catch (const mapless::ParameterError& error) {
    return error.detail().field == "min_speed_mps";
  } catch (...) {
  }
  return false;
}

}  // namespace

int main() {
  if (!exception_is_caught_by_its_type())
    return std::puts("no ParameterError came out of the shared library"), 1;

  Labeller labeller(0.2);
  std::vector<std::vector<bool>> labels;
  for (int turn = 0; turn < kTurns; ++turn) {
    std::vector<double> ranges;
    for (int laser = 0; laser < labeller.lasers(); ++laser) {
      for (int column = 0; column < labeller.columns(); ++column) {
        ranges.push_back(on_box(labeller, turn, column) ? kBox_m : kRoom_m);
      }
    }
    for (auto& ready : labeller.add(ranges)) labels.push_back(std::move(ready));
  }
  for (auto& ready : labeller.finish()) labels.push_back(std::move(ready));

  int found = 0, moving = 0, wrong = 0;
  for (int turn = 0; turn < kTurns; ++turn) {
    for (std::size_t i = 0; i < labels.at(turn).size(); ++i) {
      const bool truth = on_box(labeller, turn, static_cast<int>(i) % labeller.columns());
      moving += truth;
      found += truth && labels[turn][i];
      wrong += !truth && labels[turn][i];
    }
  }
  std::printf("%d turns, %d points of the box, %d found, %d others called moving\n", kTurns, moving, found,
              wrong);
  return found > moving / 2 && wrong < moving / 20 ? 0 : 1;
}
