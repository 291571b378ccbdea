#include "cloud_sources.hpp"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "arrays.hpp"
#include "trajectories.hpp"
#include <mapless/core/errors.hpp>

namespace mapless::python {
namespace {

namespace fs = std::filesystem;

// Python objects are let go with the GIL held, whichever thread does it.
std::shared_ptr<const void> kept(nb::object object) {
  return {new nb::object(std::move(object)), [](const void* p) {
            const nb::gil_scoped_acquire acquired;
            delete static_cast<const nb::object*>(p);
          }};
}

// Calls `use` with the GIL held; what Python raises is thrown as InputError.
template <class Use>
auto with_python(Use&& use) {
  const nb::gil_scoped_acquire acquired;
  try {
    return use();
  } catch (nb::python_error& error) {
    rethrow_as_input_error(error);
  }
}

class PythonSource final : public CloudSource {
 public:
  explicit PythonSource(nb::object source)
      : format_(nb::cast<std::string>(source.attr("format"))),
        path_(nb::cast<std::string>(source.attr("path"))),
        notes_(nb::cast<std::vector<std::string>>(source.attr("notes"))),
        source_(source) {
    for (const std::int64_t ns : nb::cast<std::vector<std::int64_t>>(source.attr("starts_ns")))
      starts_.push_back(Time::from_nanoseconds(ns));
    const nb::object trajectory = source.attr("trajectory");
    if (!trajectory.is_none()) trajectory_ = nb::cast<const TrajectoryHandle&>(trajectory).trajectory;
    for (const nb::handle one : source.attr("measurements")) measurements_.push_back(measurement_of(one));
    keeper_ = kept(std::move(source));
  }

  [[nodiscard]] std::string format() const override { return format_; }
  [[nodiscard]] fs::path path() const override { return path_; }
  [[nodiscard]] const std::vector<Time>& starts() const override { return starts_; }
  [[nodiscard]] std::vector<std::string> notes() const override { return notes_; }
  [[nodiscard]] std::shared_ptr<const Trajectory> trajectory() const override { return trajectory_; }
  [[nodiscard]] std::vector<MotionMeasurement> measurements() const override { return measurements_; }
  [[nodiscard]] fs::path scan_file(std::size_t k) const override {
    return with_python([&] { return fs::path(nb::cast<std::string>(source_.attr("scan_name")(k))); });
  }
  [[nodiscard]] Cloud read(std::size_t k) const override {
    return with_python([&] { return cloud_of(source_.attr("read_fields")(k)); });
  }
  [[nodiscard]] std::optional<std::vector<std::uint32_t>> read_labels(std::size_t k) const override {
    return with_python(
        [&] { return nb::cast<std::optional<std::vector<std::uint32_t>>>(source_.attr("read_labels")(k)); });
  }

 private:
  std::string format_;
  fs::path path_;
  std::vector<std::string> notes_;
  nb::handle source_;
  std::shared_ptr<const void> keeper_;
  std::vector<Time> starts_;
  std::shared_ptr<const Trajectory> trajectory_;
  std::vector<MotionMeasurement> measurements_;
};

}  // namespace

MotionMeasurement measurement_of(nb::handle measurement) {
  const nb::tuple t = nb::borrow<nb::tuple>(measurement);
  MotionMeasurement out;
  out.time = Time::from_nanoseconds(nb::cast<std::int64_t>(t[0]));
  if (t[1].is_none()) {
    out.quantity = MeasuredMotion::speed;
    out.value.x() = nb::cast<double>(t[2]);
    return out;
  }
  out.quantity = MeasuredMotion::angular_velocity;
  const nb::tuple turn = nb::borrow<nb::tuple>(t[1]);
  for (int axis = 0; axis < 3; ++axis)
    out.value[axis] = nb::cast<double>(turn[static_cast<std::size_t>(axis)]);
  return out;
}

nb::object measurements_of(const std::vector<MotionMeasurement>& measurements) {
  nb::list out;
  for (const MotionMeasurement& one : measurements) {
    const Eigen::Vector3d& v = one.value;
    if (one.quantity == MeasuredMotion::speed)
      out.append(nb::make_tuple(one.time.nanoseconds(), nb::none(), v.x()));
    else
      out.append(nb::make_tuple(one.time.nanoseconds(), nb::make_tuple(v.x(), v.y(), v.z()), 0.0));
  }
  return out;
}

void rethrow_as_input_error(nb::python_error& error) {
  const auto text = nb::cast<std::string>(nb::str(error.value()));
  throw InputError({"", "", "", text.empty() ? "failed in Python" : text, ""});
}

Cloud cloud_of(nb::handle fields) {
  const nb::tuple t = nb::borrow<nb::tuple>(fields);
  Cloud cloud;
  NumberSpan* const spans[] = {&cloud.fields.x, &cloud.fields.y, &cloud.fields.z, &cloud.fields.ring,
                               &cloud.fields.time};
  for (std::size_t i = 0; i < std::size(spans); ++i) *spans[i] = numbers_of(t[i]);
  cloud.fields.time_unit = static_cast<TimeUnit>(nb::cast<int>(t[5]));
  cloud.fields.time_reference = static_cast<TimeReference>(nb::cast<int>(t[6]));
  cloud.fields.rows = nb::cast<std::size_t>(t[7]);
  cloud.stamp = Time::from_nanoseconds(nb::cast<std::int64_t>(t[8]));
  if (!t[9].is_none()) cloud.compensated_to = Time::from_nanoseconds(nb::cast<std::int64_t>(t[9]));
  cloud.owner = kept(nb::borrow(fields));
  return cloud;
}

std::shared_ptr<const CloudSource> cloud_source_of(nb::object source) {
  return std::make_shared<const PythonSource>(std::move(source));
}

}  // namespace mapless::python
