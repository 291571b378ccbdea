#include <cstdio>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "io/formats/native/native_writer.hpp"
#include "support/toy_scene.hpp"
#include <mapless/core/errors.hpp>

namespace {

struct Options {
  std::string folder;
  int scans = 40;
  std::string sensor = "HDL-64E-S2";
  std::uint64_t seed = 1;
};

std::vector<mapless::TimedPose> sample(const mapless::Trajectory& trajectory) {
  std::vector<mapless::TimedPose> poses;
  const auto step = mapless::Duration::from_nanoseconds(10'000'000);
  for (mapless::Time t = trajectory.begin(); t <= trajectory.end(); t = t + step) {
    poses.push_back({t, trajectory.at(t).T_v0});
  }
  return poses;
}

void write_street(const Options& options) {
  mapless::test::ToyScene street = mapless::test::toy_street(options.sensor);
  street.seed = options.seed;
  mapless::NativeWriter writer(options.folder, *street.model);
  for (int i = 0; i < options.scans; ++i) {
    const mapless::test::ToyScan scan = mapless::test::cast_scan(street, i);
    writer.add_scan(scan.scan->start, scan.records, scan.labels);
  }
  writer.finish(sample(*street.trajectory));
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App command{"Writes the toy street as a native sequence, with labels and trajectory."};
  command.add_option("folder", options.folder, "where to; must not exist")->required();
  command.add_option("--scans", options.scans, "how many")->check(CLI::Range(1, 60))->capture_default_str();
  command.add_option("--sensor", options.sensor, "a named model")->capture_default_str();
  command.add_option("--seed", options.seed, "of the range noise")->capture_default_str();
  CLI11_PARSE(command, argc, argv);
  try {
    write_street(options);
  } catch (const mapless::Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
