// Tells for each scan of a recording how much of it moves: detect_folder RECORDING
#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <stdexcept>

#include <mapless/detection/detector.hpp>
#include <mapless/io/dataset.hpp>

namespace {

// A detection has one label per return of its scan: 0 for static, else the number of its object.
void print(const mapless::Detection& detection) {
  const auto dynamic =
      std::count_if(detection.object.begin(), detection.object.end(), [](auto label) { return label != 0; });
  std::printf("scan %zu: %td of %zu points dynamic, %d objects\n", detection.sequence_number, dynamic,
              detection.object.size(), detection.objects);
}

}  // namespace

int main(int argc, char** argv) try {
  const auto recording = mapless::open_dataset(argc > 1 ? argv[1] : ".");
  const auto trajectory = recording->trajectory();
  if (!trajectory) throw std::runtime_error("the recording has no trajectory; see io/trajectory_file.hpp");

  mapless::Detector detector;
  for (std::size_t k = 0; k < recording->size(); ++k) {
    const auto scan = std::make_shared<const mapless::LidarScan>(recording->read(k));
    for (const auto& detection : detector.process(scan, *trajectory)) print(detection);
  }
  for (const auto& detection : detector.flush()) print(detection);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
