#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "explain/point_report.hpp"
#include "explain/reasons.hpp"
#include "explain/replayed_run.hpp"
#include "support/command.hpp"
#include "support/temporary_folder.hpp"
#include "support/toy_sequence.hpp"
#include <mapless/io/files.hpp>
#include <mapless/io/labels.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using namespace app;
using test::run_command;
using testing::HasSubstr;

constexpr int kScans = 14;

class Explain : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<test::TemporaryFolder>();
    test::write_toy_sequence(test::toy_street("VLP-16"), kScans, street());
    ASSERT_EQ(run_command({"detect", street(), "-o", out("poses")}).exit_code, 0);
    ASSERT_EQ(run_command({"detect", street(), "--odometry", "-o", out("odometry")}).exit_code, 0);
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::string street() { return *folder_ / "street"; }
  static std::string out(const std::string& motion) { return *folder_ / motion; }

  static inline std::unique_ptr<test::TemporaryFolder> folder_;
};

// The sum of the recorded votes of one return, of earlier and later scans. Where it may be slow, those
// against it of the scans beside it do not count.
std::pair<int, int> sums(const ScanExplanation& e, std::size_t i) {
  std::pair<int, int> out;
  const auto source = static_cast<std::size_t>(e.source[i]);
  for (std::size_t k = 0; k < e.gaps.size(); ++k) {
    const Observation& o = e.observations[source * e.gaps.size() + k];
    if (e.points[i].may_be_slow && std::abs(e.gaps[k]) == 1 && o.votes < 0) continue;
    (e.gaps[k] > 0 ? out.first : out.second) += o.votes;
  }
  return out;
}

// Every point of three scans: what is said of it and the label and stages that mapless detect wrote.
void expect_explains(const ResultFolder& result, std::size_t k, const LabelledScan& scan, int& moving,
                     int& slow) {
  const ScanExplanation& e = *scan.detection.explanation;
  const auto& returns = scan.scan().returns;
  const auto labels = read_label_file(result.label_file(k), scan.scan().input_size);
  const auto stages = read_stage_file(result.stage_file(k), scan.scan().input_size);
  for (std::size_t i = 0; i < returns.size(); ++i) {
    const PointDecision& p = e.points[i];
    const std::uint32_t record = returns[i].input_index;
    SCOPED_TRACE(testing::Message() << "scan " << k << ", point " << record);
    const bool moves = p.proposed != 0 && e.objects.at(p.proposed - 1U).moves;
    ASSERT_EQ(moves, (labels[record] & 0xFFFFU) == kLabelDynamic);
    if (moves) {
      ASSERT_EQ(label_number(e.objects[p.proposed - 1U].object.id), labels[record] >> 16U);
      ++moving;
    }
    if (p.may_be_slow && p.proposed == 0) {  // what the report says of the rays sums up, too
      int said = 0;
      const Json report = point_json({k, i, &scan, {}}, {});
      for (const Json& o : report["observations"]) said += o["votes"].get<int>();
      ASSERT_EQ(said, p.votes());
      ++slow;
    }
    if (!p.own_vehicle) {
      ASSERT_EQ(sums(e, i), std::pair(int{p.past}, int{p.future}));
    }
    ASSERT_EQ(p.past > 0, (stages[record] >> 1U & 1U) != 0);
    ASSERT_EQ(p.votes() > 0, (stages[record] >> 2U & 1U) != 0);
    const bool kept = (stages[record] >> 3U & 1U) != 0;
    ASSERT_EQ(p.votes() > 0 && p.support >= VotingParameters{}.seed_score, kept);
    const PointStep step = step_of(p, e.limits);
    ASSERT_EQ(p.proposed != 0, step >= PointStep::seed);
    if (p.completed == Completion::none) {
      ASSERT_EQ(step == PointStep::seed || step == PointStep::few_seeds, kept);
    }
  }
}

TEST(StepOf, TellsWhatCompletedAnObject) {
  PointDecision p;
  p.proposed = 1;
  p.completed = Completion::body;
  EXPECT_EQ(step_of(p, {}), PointStep::body_completed);
  p.completed = Completion::side;
  EXPECT_EQ(step_of(p, {}), PointStep::side_completed);
}

TEST_F(Explain, SaysOfEveryPointWhatTheDetectorDecided) {
  const auto dataset = open_dataset(street());
  for (const char* motion : {"poses", "odometry"}) {
    const ResultFolder result(out(motion));
    const ReplayedRun run(*dataset, result, {});
    int scans = 0, moving = 0, slow = 0;
    run.run(
        kScans - 1, [](std::size_t k) { return k == 1 || k == 7 || k == kScans - 1; },
        [&](std::size_t k, const LabelledScan& scan) {
          ++scans;
          if (scan.detection.explanation->points_recorded) expect_explains(result, k, scan, moving, slow);
        });
    EXPECT_EQ(scans, kScans);
    EXPECT_GT(moving, 0) << motion;
    EXPECT_GT(slow, 0) << motion;
  }
}

// A point of a moving object, and one of the ground.
TEST_F(Explain, TextAndJsonNameLabelStepRaysAndObject) {
  const auto labels =
      read_label_file(ResultFolder(out("poses")).label_file(9), open_dataset(street())->read(9).input_size);
  const auto first_of = [&](std::uint32_t wanted) {
    std::size_t record = 0;
    while ((labels[record] & 0xFFFFU) != wanted) ++record;
    return record;
  };
  const std::size_t dynamic = first_of(kLabelDynamic), still = first_of(kLabelStatic);
  const auto explained = [&](std::size_t record, std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"explain", street(),  out("poses"),          "--scan",
                                      "9",       "--point", std::to_string(record)};
    words.insert(words.end(), more.begin(), more.end());
    return run_command(words);
  };
  const auto json = nlohmann::json::parse(explained(dynamic, {"--json"}).out);
  EXPECT_EQ(json["label"], "dynamic");
  EXPECT_EQ(json["object"]["number"], labels[dynamic] >> 16U);
  EXPECT_EQ(json["object"]["history"].back()["scan"], 9);
  int votes = 0;
  for (const auto& o : json["observations"]) votes += o["votes"].get<int>();
  EXPECT_EQ(votes, json["votes"]["total"]);
  EXPECT_THAT(explained(dynamic).out, HasSubstr("is DYNAMIC, object " + json["object"]["id"].dump()));
  const auto text = explained(still);
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("Point " + std::to_string(still) + " of scan 9 is STATIC."));
}

TEST_F(Explain, RefusesWhatIsNotTheRun) {
  const auto explain = [&](const std::string& result, const char* scan, const char* point) {
    return run_command({"explain", street(), result, "--scan", scan, "--point", point});
  };
  const auto no_scan = explain(out("poses"), "14", "0"), no_point = explain(out("poses"), "2", "9999999");
  EXPECT_EQ(no_scan.exit_code, 2);
  EXPECT_THAT(no_scan.err, HasSubstr("scans 0 to 13"));
  EXPECT_EQ(no_point.exit_code, 2);
  EXPECT_THAT(no_point.err, HasSubstr("no such point"));

  const std::string other = *folder_ / "other";
  std::filesystem::copy(out("poses"), other, std::filesystem::copy_options::recursive);
  std::string config = read_whole_file(ResultFolder(other).config());
  config.replace(config.find("seed_score: 32"), 14, "seed_score: 90");
  write_file_atomically(ResultFolder(other).config(), config);
  const auto changed = explain(other, "13", "0");
  EXPECT_EQ(changed.exit_code, 3);
  EXPECT_THAT(changed.err, HasSubstr("are not those that this program computes"));
}

TEST(ExplainTexts, FillInFigures) {
  EXPECT_EQ(filled_in("{a} m of {bb}.", {{"a", "1.50"}, {"bb", "7"}}), "1.50 m of 7.");
  EXPECT_EQ(filled_in("none", {}), "none");
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
