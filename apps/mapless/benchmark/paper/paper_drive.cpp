#include "benchmark/paper/paper_drive.hpp"

#include <string>
#include <utility>

#include "benchmark/paper/paper_plan.hpp"

namespace mapless::app {

PaperDrive::PaperDrive(const RecordingKey& key)
    : scene_(make_scene(key.scene, {key.seed, key.duration_s, true})),
      model_(std::make_shared<const LidarModel>(paper_sensor())),
      trajectory_(std::make_shared<const SampledTrajectory>(scene_.poses, Duration(), key.scene)),
      world_(scene_.world),
      sensor_(model_, trajectory_, world_, {key.range_noise_m, key.faulty, key.seed}) {}

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
