#include "arrays.hpp"

#include <array>
#include <string>
#include <string_view>
#include <utility>

#include <nanobind/stl/string.h>

namespace mapless::python {
namespace {

constexpr std::array<std::pair<std::string_view, NumberType>, 10> kTypes = {{{"i1", NumberType::int8},
                                                                             {"u1", NumberType::uint8},
                                                                             {"i2", NumberType::int16},
                                                                             {"u2", NumberType::uint16},
                                                                             {"i4", NumberType::int32},
                                                                             {"u4", NumberType::uint32},
                                                                             {"i8", NumberType::int64},
                                                                             {"u8", NumberType::uint64},
                                                                             {"f4", NumberType::float32},
                                                                             {"f8", NumberType::float64}}};

// "<f4": byte order, kind, bytes.
NumberType type_of(const std::string& text) {
  for (const auto& [name, type] : kTypes) {
    if (text.substr(1) == name && text[0] != '>') return type;
  }
  throw nb::type_error(("numbers of type " + text + " are not read").c_str());
}

}  // namespace

// Not the buffer protocol, which the stable ABI has from Python 3.11 on, nor DLPack, which refuses the
// unaligned fields of structured arrays.
NumberSpan numbers_of(nb::handle array) {
  if (array.is_none()) return {};
  if (!nb::hasattr(array, "__array_interface__")) throw nb::type_error("not a NumPy array");
  const nb::object interface = array.attr("__array_interface__");
  const nb::tuple shape(interface["shape"]);
  if (nb::len(shape) != 1) throw nb::type_error("not a one-dimensional array");
  const NumberType type = type_of(nb::cast<std::string>(interface["typestr"]));
  const auto address = nb::cast<std::uintptr_t>(nb::tuple(interface["data"])[0]);
  const auto stride = nb::cast<std::int64_t>(nb::tuple(array.attr("strides"))[0]);
  if (stride < 0) throw nb::type_error("an array that runs backwards");
  return {reinterpret_cast<const void*>(address), type, nb::cast<std::size_t>(shape[0]),
          static_cast<std::size_t>(stride)};
}

}  // namespace mapless::python
