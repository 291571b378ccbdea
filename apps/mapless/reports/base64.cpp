#include "reports/base64.hpp"

#include <cstdint>

namespace mapless::app {

std::string base64(std::string_view bytes) {
  static constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) {
      return k < bytes.size() ? static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[k])) : 0U;
    };
    const std::uint32_t three = byte(i) << 16U | byte(i + 1) << 8U | byte(i + 2);
    out.push_back(kDigits[three >> 18U]);
    out.push_back(kDigits[three >> 12U & 63U]);
    out.push_back(i + 1 < bytes.size() ? kDigits[three >> 6U & 63U] : '=');
    out.push_back(i + 2 < bytes.size() ? kDigits[three & 63U] : '=');
  }
  return out;
}

}  // namespace mapless::app
