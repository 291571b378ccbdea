#include <filesystem>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "benchmark/paper/paper_figures.hpp"
#include "benchmark/paper/paper_page.hpp"
#include "benchmark/paper/paper_plan.hpp"
#include "benchmark/paper/paper_unit_run.hpp"
#include "reports/evaluation_json.hpp"
#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace MAPLESS_FILE {

using Json = nlohmann::ordered_json;

TEST(PaperPlan, HasBothTownsInFullWithTheRaysOfThePaper) {
  std::size_t every_scan = 0;
  std::set<double> noises, thresholds;
  std::set<std::string> stems;
  const auto units = make_paper_plan({});
  for (const PaperUnit& unit : units) {
    EXPECT_EQ(unit.sensor().lasers.size() * static_cast<std::size_t>(unit.sensor().columns), 128000u);
    stems.insert(unit.stem());
    if (unit.part == PaperUnit::Part::every_scan) {
      every_scan += unit.count;
      continue;
    }
    noises.insert(unit.recording.range_noise_m);
    for (const PaperRun& run : unit.runs) {
      thresholds.insert(run.threshold_m);
      EXPECT_LE(run.lead, unit.first) << "the detector has its scans before";
    }
  }
  EXPECT_EQ(every_scan, 2u * 3000);
  EXPECT_EQ(noises, (std::set<double>{0, 0.02, 0.05}));
  EXPECT_EQ(*thresholds.begin(), 0.05);
  EXPECT_EQ(*thresholds.rbegin(), 2);
  EXPECT_EQ(stems.size(), units.size()) << "a file each";
}

TEST(PaperPlan, TheQuickVersionIs20SecondsOfEachTown) {
  std::size_t every_scan = 0;
  PaperOptions quick;
  quick.quick = true;
  for (const PaperUnit& unit : make_paper_plan(quick)) {
    if (unit.part == PaperUnit::Part::every_scan) every_scan += unit.count;
  }
  EXPECT_EQ(every_scan, 2u * 200);
  quick.duration_s = 0.01;
  EXPECT_THROW(static_cast<void>(make_paper_plan(quick)), ParameterError);
}

TEST(PaperFigures, PooledCountsAreSumsAndAveragesAreOverAllScans) {
  // Scans with precision 1 and 1/2, recall 1/2 and 1; then one with neither, one with precision 0.
  PrecisionRecall first, second, all;
  const std::vector<Counts> scans = {{.tp = 1, .fn = 1}, {.tp = 1, .fp = 1}, {.tn = 5}, {.fp = 2}};
  for (std::size_t i = 0; i < scans.size(); ++i) {
    (i < 2 ? first : second).add(scans[i]);
    all.add(scans[i]);
  }
  const Json pooled = pooled_rates(to_json(first), to_json(second));
  EXPECT_EQ(pooled, to_json(all));
  EXPECT_DOUBLE_EQ(pooled["average_precision"], 0.5);  // (1 + 1/2 + 0) / 3
  EXPECT_EQ(pooled["n_p"], 3);
  EXPECT_DOUBLE_EQ(pooled["average_recall"], 0.75);  // (1/2 + 1) / 2
}

/// Scans [first, first + count) of a small sensor in a tunnel, by the published method without and with
/// motion compensation.
PaperUnit small_unit(PaperUnit::Part part, std::size_t first, std::size_t count) {
  PaperUnit unit;
  unit.part = part;
  unit.recording.scene = "tunnel";
  unit.recording.sensor = "VLP-16";
  unit.recording.duration_s = 1.2;
  unit.columns = 300;
  unit.first = first;
  unit.count = count;
  for (const char* treatment : {"full", "no motion compensation"}) {
    PaperRun run{
        "paper", treatment, 0.1, with_error_threshold(detector_profile("paper"), 0.1), Compensation::full, 5};
    if (unit.runs.size() == 1) run.compensation = Compensation::none;
    unit.runs.push_back(run);
  }
  return unit;
}

Json result_of(const PaperUnit& unit, const std::filesystem::path& pictures, std::size_t* steps = nullptr) {
  return run_unit(unit, pictures,
                  [steps] {
                    if (steps != nullptr) ++*steps;
                  })
      .value();
}

TEST(PaperUnitRun, ADriveCutInTwoHasTheFiguresOfTheWhole) {
  using enum PaperUnit::Part;
  const test::TemporaryFolder folder;
  std::size_t steps = 0;
  const PaperUnit whole = small_unit(sweep, 0, 12);
  const Json all = paper_figures({whole}, {result_of(whole, folder / "", &steps)});
  EXPECT_EQ(steps, steps_of(whole));
  EXPECT_EQ(all["sweep"][0]["final"]["scans"], 12);
  // After the comparison; so few rays leave nothing at the end.
  EXPECT_GT(all["sweep"][0]["stages"][0]["tp"], 0);
  EXPECT_NE(all["sweep"][0]["stages"][0]["fp"], all["sweep"][1]["stages"][0]["fp"]) << "not compensated";
  const PaperUnit a = small_unit(sweep, 0, 7), b = small_unit(sweep, 7, 5);
  const Json parts = paper_figures({a, b}, {result_of(a, folder / ""), result_of(b, folder / "")});
  for (std::size_t run : {0, 1}) {
    for (const char* count : {"scans", "tp", "fp", "fn", "tn", "n_p", "n_r"})
      EXPECT_EQ(parts["sweep"][run]["stages"][0][count], all["sweep"][run]["stages"][0][count]) << count;
  }
}

TEST(PaperUnitRun, EveryScanGivesRangesTimesPicturesAndAPage) {
  const test::TemporaryFolder folder;
  const BenchmarkFolder out(folder / "out", "build");
  out.open();
  PaperUnit unit = small_unit(PaperUnit::Part::every_scan, 0, 2);
  unit.columns = 1800;  // enough points for a picture of a mover
  unit.pictures = true;
  const PaperUnit swept = small_unit(PaperUnit::Part::sweep, 6, 2);
  Json figures = paper_figures({unit, swept}, {result_of(unit, out.pictures()), result_of(swept, "")});
  EXPECT_EQ(figures["every_scan"][0]["within_range"].back()["tp"], figures["every_scan"][0]["final"]["tp"]);
  EXPECT_GT(figures["every_scan"][0]["timing"]["total"]["median_ms"], 0);
  EXPECT_EQ(figures["pictures"][0]["town"], "tunnel");
  figures.update(Json{{"version", "1"},
                      {"duration_s", 1.2},
                      {"seed", 1},
                      {"processor", "p"},
                      {"threads", 2},
                      {"date", "d"},
                      {"quick", true}});
  write_paper_page(figures, out);
  const std::string page = read_whole_file(out.page());
  for (const char* text :
       {"tunnel, paper", "data:image/png;base64,", "no motion compensation", "Milliseconds"})
    EXPECT_NE(page.find(text), std::string::npos) << text;
  EXPECT_TRUE(std::filesystem::is_regular_file(out.plots() / "stages_tunnel.png"));
  EXPECT_THAT(paper_text(figures), testing::HasSubstr("tunnel"));
}

TEST(BenchmarkPaper, RefusesWhatItDoesNotUse) {
  const test::TemporaryFolder folder;
  for (const auto& [option, value] :
       {std::pair("--scenes", "forest"), {"--noise", "0"}, {"--profile", "paper"}, {"--faulty", "off"}}) {
    const auto r = test::run_command({"benchmark", "--paper", option, value, "-o", folder / "out"});
    EXPECT_EQ(r.exit_code, 2) << r.err;
    EXPECT_THAT(r.err, testing::HasSubstr(option));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless::app
