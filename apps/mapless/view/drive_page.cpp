#include "view/drive_page.hpp"

#include <mutex>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "reports/base64.hpp"
#include "reports/json_text.hpp"
#include "view/scan_block.hpp"

namespace mapless::app {
namespace {

constexpr std::string_view kDriveMark = "<!--mapless:drive-->", kScansMark = "<!--mapless:scans-->",
                           kPolicyStart = "default-src 'none';";

std::string data_element(std::string_view what, std::size_t k, const std::string& bytes) {
  return fmt::format("<script type=\"text/plain\" id=\"{}-{}\">{}</script>\n", what, k, base64(bytes));
}

std::string drive_element(const Json& header) {
  return "<script type=\"application/json\" id=\"drive\">" + json_for_script(header) + "</script>\n";
}

std::string with_header(const Json& header, const std::string& bytes) {
  const std::string json = header.dump();
  std::string out;
  for (unsigned shift = 0; shift < 32; shift += 8)
    out.push_back(static_cast<char>((json.size() >> shift) & 0xFFU));
  return out + json + bytes;
}

struct PageScan {
  Json header;
  std::string element;
};

// Scans are read and compressed by all threads, and stay in their order.
std::vector<PageScan> encode_all(const DriveEncoder& encoder,
                                 const std::function<void(std::size_t, std::size_t)>& progress) {
  const std::vector<std::size_t>& scans = encoder.scans();
  std::vector<PageScan> out(scans.size());
  std::mutex printing;
  std::size_t done = 0;
  tbb::parallel_for(std::size_t{0}, scans.size(), [&](std::size_t i) {
    DriveEncoder::EncodedScan scan = encoder.encode(scans[i]);
    out[i] = {std::move(scan.header), data_element("scan", scans[i], compress_zlib(scan.bytes))};
    const std::lock_guard<std::mutex> lock(printing);
    if (progress) progress(++done, scans.size());
  });
  return out;
}

}  // namespace

std::string drive_page(const DriveEncoder& encoder, const PageTitle& title, const ExplainedDrive& explained,
                       const std::function<void(std::size_t, std::size_t)>& progress) {
  const std::vector<PageScan> encoded = encode_all(encoder, progress);
  Json header = encoder.header(title);
  header["scans"] = Json::array();
  for (const PageScan& scan : encoded) header["scans"].push_back(scan.header);
  if (!explained.blocks.empty()) header["explanations"] = explained.header;

  const std::string_view page = page_template();
  const std::size_t drive_at = page.find(kDriveMark), scans_at = page.find(kScansMark);
  // The first scan comes before the program, which draws it while the browser still reads the others.
  std::string out(page.substr(0, drive_at));
  out += drive_element(header) + encoded.front().element;
  out += page.substr(drive_at + kDriveMark.size(), scans_at - drive_at - kDriveMark.size());
  for (std::size_t i = 1; i < encoded.size(); ++i) out += encoded[i].element;
  for (const std::size_t k : encoder.scans()) {
    const auto block = explained.blocks.find(k);
    if (block != explained.blocks.end()) out += data_element("explain", k, block->second);
  }
  out += page.substr(scans_at + kScansMark.size());
  return out;
}

std::string served_page(const DriveEncoder& encoder, const PageTitle& title, bool explained) {
  Json header = encoder.header(title);
  header["served"] = true;
  header["explained"] = explained;
  header["scans"] = Json::array();
  for (const std::size_t k : encoder.scans()) header["scans"].push_back(encoder.outline(k));
  std::string out(page_template());
  out.replace(out.find(kDriveMark), kDriveMark.size(), drive_element(header));
  out.replace(out.find(kScansMark), kScansMark.size(), "");
  // The page in a file may load nothing; this one its scans.
  out.insert(out.find(kPolicyStart) + kPolicyStart.size(), " connect-src 'self';");
  return out;
}

std::string served_scan(const DriveEncoder& encoder, std::size_t scan) {
  const DriveEncoder::EncodedScan encoded = encoder.encode(scan);
  return with_header(encoded.header, encoded.bytes);
}

std::string served_explanation(const Json& header, const std::string& block) {
  return with_header(header, block);
}

}  // namespace mapless::app
