#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "detection/dynamic_returns.hpp"

namespace mapless::inline v1 {

/// The returns of each object of a scan, by its number in Detection::object; number 0 has none.
class ObjectMembers {
 public:
  explicit ObjectMembers(const std::vector<std::uint16_t>& object) {
    std::vector<std::int32_t> dynamic;
    for_each_dynamic(object, [&](std::size_t i) { dynamic.push_back(static_cast<std::int32_t>(i)); });
    const auto number = [&](std::int32_t i) -> std::size_t { return object[static_cast<std::size_t>(i)]; };
    for (const std::int32_t i : dynamic) {
      if (number(i) + 2 > begins_.size()) begins_.resize(number(i) + 2, 0);
      ++begins_[number(i) + 1];
    }
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    members_.resize(dynamic.size());
    std::vector<std::size_t> next = begins_;
    for (const std::int32_t i : dynamic) members_[next[number(i)]++] = i;
  }
  [[nodiscard]] std::size_t numbers() const { return begins_.empty() ? 0 : begins_.size() - 1; }
  [[nodiscard]] std::span<const std::int32_t> of(std::size_t number) const {
    return {members_.begin() + static_cast<std::ptrdiff_t>(begins_[number]),
            begins_[number + 1] - begins_[number]};
  }

 private:
  std::vector<std::int32_t> members_;  // by number
  std::vector<std::size_t> begins_;    // of each number among them, and the end
};

}  // namespace mapless
