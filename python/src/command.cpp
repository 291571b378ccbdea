#include "command.hpp"

#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "cloud_sources.hpp"
#include "options/parameter_options.hpp"
#include "options/recording_reader.hpp"
#include "recordings.hpp"
#include "verbs/command.hpp"

namespace mapless::python {
namespace {

// The verbs own their Dataset; this one is shared with Python.
class SharedDataset final : public Dataset {
 public:
  explicit SharedDataset(std::shared_ptr<const Dataset> shared) : shared_(std::move(shared)) {}
  [[nodiscard]] std::string format() const override { return shared_->format(); }
  [[nodiscard]] std::size_t size() const override { return shared_->size(); }
  [[nodiscard]] std::shared_ptr<const LidarModel> model() const override { return shared_->model(); }
  [[nodiscard]] std::optional<ModelEstimate> model_estimate() const override {
    return shared_->model_estimate();
  }
  [[nodiscard]] Time scan_start(std::size_t k) const override { return shared_->scan_start(k); }
  [[nodiscard]] Time scan_end(std::size_t k) const override { return shared_->scan_end(k); }
  [[nodiscard]] std::filesystem::path scan_file(std::size_t k) const override {
    return shared_->scan_file(k);
  }
  [[nodiscard]] LidarScan read(std::size_t k) const override { return shared_->read(k); }
  [[nodiscard]] std::optional<std::vector<std::uint32_t>> read_labels(std::size_t k) const override {
    return shared_->read_labels(k);
  }
  [[nodiscard]] std::shared_ptr<const Trajectory> trajectory() const override {
    return shared_->trajectory();
  }
  [[nodiscard]] std::vector<MotionMeasurement> measurements() const override {
    return shared_->measurements();
  }
  [[nodiscard]] std::vector<std::string> notes() const override { return shared_->notes(); }

 private:
  std::shared_ptr<const Dataset> shared_;
};

std::unique_ptr<Dataset> open_in_python(nb::handle opener, const std::filesystem::path& path,
                                        const DatasetOptions& options,
                                        const std::map<std::string, std::string>& given) {
  const nb::gil_scoped_acquire acquired;
  try {
    const nb::object opened = opener(path.string(), options.format, options.sensor, given);
    if (opened.is_none()) return nullptr;
    return std::make_unique<SharedDataset>(nb::cast<const RecordingHandle&>(opened).dataset);
  } catch (nb::python_error& error) {
    rethrow_as_input_error(error);
  }
}

int run_command(std::vector<std::string> arguments) {
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const nb::gil_scoped_release released;
  return app::run_command(static_cast<int>(arguments.size()), argv.data());
}

// For as long as the process runs: the opener is a function of the package.
void set_reader(nb::object opener, std::vector<std::string> formats,
                const std::vector<std::pair<std::string, std::string>>& options) {
  app::RecordingReader reader;
  reader.formats = std::move(formats);
  for (const auto& [flag, help] : options) reader.options.push_back({flag, help});
  const nb::handle kept = opener.release();
  reader.open = [kept](const auto& path, const DatasetOptions& of_dataset, const auto& given) {
    return open_in_python(kept, path, of_dataset, given);
  };
  app::set_recording_reader(std::move(reader));
}

using ParameterRow = std::tuple<std::string, std::string, std::string, std::vector<std::string>, std::string>;

// Key, type, unit, choices, help.
std::vector<ParameterRow> parameter_table() {
  app::RunParameters parameters;
  std::vector<ParameterRow> rows;
  for (const ParameterReference& p : app::references_of(parameters)) {
    std::vector<std::string> choices;
    if (const auto* choice = std::get_if<ChoiceReference>(&p.value))
      choices.assign(choice->names.begin(), choice->names.end());
    rows.emplace_back(p.key, p.type(), p.unit, std::move(choices), p.help);
  }
  return rows;
}

}  // namespace

void bind_command(nb::module_& m) {
  m.def("run_command", run_command, nb::arg("arguments"));
  m.def("set_reader", set_reader, nb::arg("opener"), nb::arg("formats"), nb::arg("options"));
  m.def("parameter_table", parameter_table);
}

}  // namespace mapless::python
