#include "benchmark/paper/paper_figures.hpp"

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>

#include "reports/evaluation_json.hpp"
#include "reports/json.hpp"
#include <mapless/evaluation/evaluator.hpp>
#include <mapless/evaluation/trajectory_evaluation.hpp>

namespace mapless::app {
namespace {

Counts counts_of(const Json& rates) {
  return {rates["tp"].get<std::int64_t>(), rates["fp"].get<std::int64_t>(), rates["fn"].get<std::int64_t>(),
          rates["tn"].get<std::int64_t>()};
}

// Mean of two means, each over its number of scans.
Json mean_of(const Json& a, std::int64_t of_a, const Json& b, std::int64_t of_b) {
  if (of_a + of_b == 0) return nullptr;
  const double sum = (of_a > 0 ? a.get<double>() * static_cast<double>(of_a) : 0) +
                     (of_b > 0 ? b.get<double>() * static_cast<double>(of_b) : 0);
  return sum / static_cast<double>(of_a + of_b);
}

Json pooled_average(const Json& a, const Json& b, const char* mean, const char* number) {
  return mean_of(a[mean], a[number].get<std::int64_t>(), b[mean], b[number].get<std::int64_t>());
}

// Lists of rates of the same length, item by item: "stages" or "within_range".
void pool_lists(Json& into, const Json& other) {
  for (std::size_t i = 0; i < into.size(); ++i) into[i] = pooled_rates(into[i], other[i]);
}

/// The rows of one part, in the order in which their first unit came.
class Rows {
 public:
  void add(const PaperUnit& unit, const Json& run) {
    const std::tuple key{unit.recording.scene, unit.recording.range_noise_m, run["method"].get<std::string>(),
                         run["treatment"].get<std::string>(), run["threshold_m"].get<double>()};
    const auto [place, is_new] = places_.try_emplace(key, rows_.size());
    if (is_new) {
      Json row = {{"town", unit.recording.scene}, {"range_noise_m", unit.recording.range_noise_m}};
      row.update(run);
      rows_.push_back(row);
      timings_.emplace_back();
    } else {
      pool(rows_[place->second], run);
    }
    if (run.contains("timing")) timings_[place->second].push_back(run["timing"]);
  }
  [[nodiscard]] Json json() const {
    Json out = Json::array();
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      out.push_back(rows_[i]);
      if (!timings_[i].empty()) out.back()["timing"] = median_timing(timings_[i]);
    }
    return out;
  }

 private:
  static void pool(Json& row, const Json& run) {
    row["final"] = pooled_rates(row["final"], run["final"]);
    pool_lists(row["stages"], run["stages"]);
    if (run.contains("within_range")) pool_lists(row["within_range"], run["within_range"]);
  }
  static Json median_timing(const std::vector<Json>& timings) {
    Json out = timings.front();
    for (auto& [stage, figures] : out.items()) {
      for (auto& [name, value] : figures.items()) {
        std::vector<double> values;
        for (const Json& timing : timings) {
          if (timing[stage][name].is_number()) values.push_back(timing[stage][name].get<double>());
        }
        const auto median = quantile(values, 0.5);
        value = median ? Json(*median) : Json(nullptr);
      }
    }
    return out;
  }

  std::map<std::tuple<std::string, double, std::string, std::string, double>, std::size_t> places_;
  std::vector<Json> rows_;
  std::vector<std::vector<Json>> timings_;  // of each row, by unit
};

}  // namespace

Json pooled_rates(const Json& a, const Json& b) {
  Counts counts = counts_of(a);
  counts += counts_of(b);
  Json out = a;
  out.update(to_json(counts));
  out["scans"] = a["scans"].get<std::int64_t>() + b["scans"].get<std::int64_t>();
  out["average_precision"] = pooled_average(a, b, "average_precision", "n_p");
  out["average_recall"] = pooled_average(a, b, "average_recall", "n_r");
  for (const char* number : {"n_p", "n_r"})
    out[number] = a[number].get<std::int64_t>() + b[number].get<std::int64_t>();
  return out;
}

Json paper_figures(const std::vector<PaperUnit>& units, const std::vector<Json>& results) {
  Rows sweep, every_scan;
  Json pictures = Json::array();
  for (std::size_t i = 0; i < units.size(); ++i) {
    for (const Json& run : results[i]["runs"])
      (units[i].part == PaperUnit::Part::sweep ? sweep : every_scan).add(units[i], run);
    for (Json picture : results[i]["pictures"]) {
      picture["town"] = units[i].recording.scene;
      pictures.push_back(picture);
    }
  }
  return {{"sweep", sweep.json()}, {"every_scan", every_scan.json()}, {"pictures", pictures}};
}

}  // namespace mapless::app
