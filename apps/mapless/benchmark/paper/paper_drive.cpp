#include "benchmark/paper/paper_drive.hpp"

#include <string>
#include <utility>

namespace mapless::app {

PaperDrive::PaperDrive(const PaperUnit& unit)
    : scene_(make_scene(unit.recording.scene, {unit.recording.seed, unit.recording.duration_s, true})),
      model_(std::make_shared<const LidarModel>(unit.sensor())),
      trajectory_(std::make_shared<const SampledTrajectory>(scene_.poses, Duration(), unit.recording.scene)),
      world_(scene_.world),
      sensor_(model_, trajectory_, world_,
              {unit.recording.range_noise_m, unit.recording.faulty, unit.recording.seed}) {}

TrueScan PaperDrive::scan(std::size_t number) {
  SimulatedScan cast = sensor_.scan(static_cast<int>(number));
  LidarScan out;
  out.model = model_;
  out.start = cast.start;
  out.column_period = Duration::from_seconds(1 / model_->rotation_rate_hz / model_->columns);
  out.columns = model_->columns;
  return {std::make_shared<const LidarScan>(organise(std::move(out), cast.records, "simulated scan")),
          std::move(cast.labels)};
}

ObjectTruth PaperDrive::objects() const {
  ObjectTruth out;
  out.has_descriptions = true;
  for (const Mover& mover : scene_.world.movers)
    out.descriptions[static_cast<std::uint32_t>(mover.object_id)] = {
        std::string(to_string(mover.object_class)), "mover"};
  return out;
}

}  // namespace mapless::app
