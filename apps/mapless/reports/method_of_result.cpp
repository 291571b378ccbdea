#include "reports/method_of_result.hpp"

#include <fstream>
#include <string>

namespace mapless::app {

const StageNames& stage_names_of(const ResultFolder& result) {
  std::ifstream config(result.config());
  for (std::string line; std::getline(config, line);) {
    if (line.starts_with("method: published")) return stage_names(DetectionMethod::published);
  }
  return stage_names(DetectionMethod::voting);
}

}  // namespace mapless::app
