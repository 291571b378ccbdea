#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::python {

namespace nb = nanobind;

/// The numbers of a one-dimensional NumPy array of native byte order, not copied: the array must outlive
/// them. Empty for None. Throws nb::type_error for any other object or type of number.
[[nodiscard]] NumberSpan numbers_of(nb::handle array);

/// A NumPy array that owns `numbers`.
template <class Number>
[[nodiscard]] nb::object owned_array(std::vector<Number> numbers, std::initializer_list<std::size_t> shape) {
  auto* const kept = new std::vector<Number>(std::move(numbers));
  const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<Number>*>(p); });
  return nb::ndarray<nb::numpy, Number>(kept->data(), shape, owner).cast();
}

template <class Number>
[[nodiscard]] nb::object owned_array(std::vector<Number> numbers) {
  const std::size_t count = numbers.size();
  return owned_array(std::move(numbers), {count});
}

}  // namespace mapless::python
