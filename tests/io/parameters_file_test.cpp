#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/detection/parameters.hpp>
#include <mapless/io/atomic_file.hpp>
#include <mapless/io/parameters_file.hpp>

namespace mapless {
namespace {

using testing::HasSubstr;

class ParametersFileTest : public testing::Test {
 protected:
  void read(const std::string& yaml) {
    write_file_atomically(file, yaml);
    read_parameters_file(file, parameter_references(parameters));
  }
  // The message of the error that reading `yaml` throws.
  template <class ErrorType>
  std::string error_of(const std::string& yaml) {
    try {
      read(yaml);
    } catch (const ErrorType& error) {
      return error.what();
    }
    ADD_FAILURE() << "no such error";
    return "";
  }

  test::TemporaryFolder folder;
  std::filesystem::path file = folder / "config.yaml";
  DetectorParameters parameters;
};

TEST_F(ParametersFileTest, SetsNestedKeysAndKeepsTheRest) {
  read(
      "scan_gap: 3\nfreespace:\n  border_radius_m: 0.75\n  require_near_ray: false\nnormals: {method: "
      "nearest_neighbours}\n");
  EXPECT_EQ(parameters.scan_gap, 3);
  EXPECT_EQ(parameters.freespace.border_radius_m, 0.75);
  EXPECT_FALSE(parameters.freespace.require_near_ray);
  EXPECT_EQ(parameters.normals.method, NormalMethod::nearest_neighbours);
  EXPECT_EQ(parameters.forward_gap, DetectorParameters().forward_gap);
}

TEST_F(ParametersFileTest, AnEmptyFileChangesNothing) {
  read("# nothing\n");
  EXPECT_EQ(parameters.scan_gap, DetectorParameters().scan_gap);
}

TEST_F(ParametersFileTest, ReadsBackWhatWasWritten) {
  parameters = detector_profile("paper");
  parameters.freespace.border_radius_per_m = 1.0 / 3;
  DetectorParameters defaults;
  const std::string yaml = parameters_yaml(parameter_references(parameters), parameter_references(defaults));
  DetectorParameters read_back;
  write_file_atomically(file, yaml);
  read_parameters_file(file, parameter_references(read_back));
  const auto written = parameter_references(parameters), found = parameter_references(read_back);
  for (std::size_t i = 0; i < written.size(); ++i)
    EXPECT_EQ(written[i].text(), found[i].text()) << written[i].key;
  EXPECT_EQ(read_back.freespace.border_radius_per_m, 1.0 / 3);
}

TEST_F(ParametersFileTest, WritesMeaningUnitBoundsAndDefaultOfEachParameter) {
  parameters.comparison.error_threshold_m = 0.5;
  DetectorParameters defaults;
  const std::string yaml = parameters_yaml(parameter_references(parameters), parameter_references(defaults));
  EXPECT_THAT(yaml, HasSubstr("\ncomparison:\n"));
  EXPECT_THAT(yaml, HasSubstr("\n  error_threshold_m: 0.5\n"));
  EXPECT_THAT(yaml, HasSubstr("0.001 to 10 m; default 0.2; paper step 2"));
}

TEST_F(ParametersFileTest, NamesFileLineAndKeyOfWhatItRefuses) {
  EXPECT_THAT(error_of<ParameterError>("scan_gap: 3\nscan_gab: 4\n"),
              testing::AllOf(HasSubstr(file.string() + ":2"), HasSubstr("scan_gab")));
  EXPECT_THAT(error_of<ParameterError>("freespace:\n  border_m: 1\n"),
              testing::AllOf(HasSubstr(":2"), HasSubstr("freespace.border_m")));
  EXPECT_THAT(error_of<ParameterError>("freespace:\n  border_radius_m: -1\n"),
              testing::AllOf(HasSubstr(":2"), HasSubstr("freespace.border_radius_m"), HasSubstr("-1")));
  EXPECT_THAT(error_of<ParameterError>("\nscan_gap: four\n"),
              testing::AllOf(HasSubstr(":2"), HasSubstr("four")));
  EXPECT_THAT(error_of<ParameterError>("scan_gap: 3\nscan_gap: 4\n"), HasSubstr(":2"));
}

TEST_F(ParametersFileTest, RefusesValuesOfAnotherShape) {
  for (const char* yaml :
       {"scan_gap: [1, 2]\n", "scan_gap:\n", "scan_gap: {a: 1}\n", "freespace: 3\n", "freespace:\n",
        "[1, 2]\n", "3\n", "? [1]\n: 2\n", "freespace: &a {freespace: *a}\n"}) {
    SCOPED_TRACE(yaml);
    EXPECT_THROW(read(yaml), ParameterError);
  }
}

TEST_F(ParametersFileTest, RefusesWhatIsNotYaml) {
  EXPECT_THAT(error_of<InputError>("scan_gap: 3\n  a: [\n"), HasSubstr(file.string() + ":"));
  EXPECT_THROW(read_parameters_file(folder / "absent.yaml", parameter_references(parameters)), InputError);
}

}  // namespace
}  // namespace mapless
