// Prints how many points of each scan of a recording are dynamic: detect_folder RECORDING
#include <algorithm>
#include <cstdio>
#include <exception>

#include <mapless/io/dataset.hpp>
#include <mapless/pipeline/online_detector.hpp>

namespace {

// A detection has one label per return of its scan: 0 for static, else the number of its object.
void print(const mapless::LabelledScan& found) {
  const auto& object = found.detection.object;
  const auto dynamic = std::count_if(object.begin(), object.end(), [](auto number) { return number != 0; });
  const auto position_0 = found.T_0v().translation();
  std::printf("scan %zu at (%.2f, %.2f) m: %td of %zu points dynamic, %d objects\n",
              found.detection.sequence_number, position_0.x(), position_0.y(), dynamic, object.size(),
              found.detection.objects);
}

}  // namespace

int main(int argc, char** argv) try {
  const auto recording = mapless::open_dataset(argc > 1 ? argv[1] : ".");
  const auto poses = recording->trajectory();  // null where it has none: lidar odometry estimates them

  mapless::OnlineDetector online;
  for (std::size_t k = 0; k < recording->size(); ++k) {
    for (const auto& found : online.push(recording->read(k), poses)) print(found);
  }
  for (const auto& found : online.flush()) print(found);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
