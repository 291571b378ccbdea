#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

#include <mapless/lidar/lidar_scan.hpp>

namespace mapless::inline v1 {

/// Calls visit with a 0 of the type.
template <class Visit>
void with_type(NumberType type, Visit&& visit) {
  switch (type) {
    case NumberType::int8:
      return visit(std::int8_t{});
    case NumberType::uint8:
      return visit(std::uint8_t{});
    case NumberType::int16:
      return visit(std::int16_t{});
    case NumberType::uint16:
      return visit(std::uint16_t{});
    case NumberType::int32:
      return visit(std::int32_t{});
    case NumberType::uint32:
      return visit(std::uint32_t{});
    case NumberType::int64:
      return visit(std::int64_t{});
    case NumberType::uint64:
      return visit(std::uint64_t{});
    case NumberType::float32:
      return visit(float{});
    case NumberType::float64:
      return visit(double{});
  }
}

/// Calls visit(i, number) for each number from `begin` to before `end` in its own type, in order.
template <class Visit>
void for_each_number(const NumberSpan& numbers, std::size_t begin, std::size_t end, Visit&& visit) {
  with_type(numbers.type, [&](auto zero) {
    const auto* at = static_cast<const char*>(numbers.first) + begin * numbers.stride_bytes;
    for (std::size_t i = begin; i < end; ++i, at += numbers.stride_bytes) {
      auto number = zero;
      std::memcpy(&number, at, sizeof(number));
      visit(i, number);
    }
  });
}

template <class Visit>
void for_each_number(const NumberSpan& numbers, Visit&& visit) {
  for_each_number(numbers, 0, numbers.size, std::forward<Visit>(visit));
}

}  // namespace mapless
