#include <bit>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using testing::ElementsAre;
using testing::HasSubstr;

template <class Number>
Number number_at(const std::string& bytes, std::size_t at) {
  Number out;
  std::memcpy(&out, bytes.data() + at, sizeof out);
  return out;
}

std::size_t data_of(const std::string& bytes, const std::string& last_header_line) {
  return bytes.find(last_header_line) + last_header_line.size();
}

TEST(CloudFile, PcdHasFloatsAndColumns) {
  const ExportCloud cloud{{{1, 2, 3}, {-4, 5.5, 6}}, {{"label", {9, 251}}}};
  const std::string bytes = cloud_file(cloud, CloudFormat::pcd);
  EXPECT_THAT(bytes, HasSubstr("FIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 2\n"));
  const std::size_t data = data_of(bytes, "DATA binary\n");
  ASSERT_EQ(bytes.size(), data + 2 * 16);
  EXPECT_EQ(number_at<float>(bytes, data + 16), -4);
  EXPECT_EQ(number_at<float>(bytes, data + 20), 5.5F);
  EXPECT_EQ(number_at<std::uint32_t>(bytes, data + 28), 251U);
}

// Type 9 of extra bytes is float (LAS 1.4-R15, table 24).
TEST(CloudFile, EveryFormatHasColumnsOfFloats) {
  const ExportCloud cloud{{{1, 2, 3}}, {{"probability", {std::bit_cast<std::uint32_t>(0.25F)}, true}}};
  const std::string pcd = cloud_file(cloud, CloudFormat::pcd), ply = cloud_file(cloud, CloudFormat::ply);
  const std::string las = cloud_file(cloud, CloudFormat::las);
  EXPECT_THAT(pcd, HasSubstr("FIELDS x y z probability\nSIZE 4 4 4 4\nTYPE F F F F\n"));
  EXPECT_THAT(ply, HasSubstr("property float probability\nend_header\n"));
  EXPECT_EQ(number_at<std::uint8_t>(las, 375 + 54 + 2), 9);
  for (const std::string& bytes : {pcd, ply, las})
    EXPECT_EQ(number_at<float>(bytes, bytes.size() - 4), 0.25F);
}

TEST(CloudFile, FarCoordinatesAreDoublesInPlyAsInPcd) {
  const double east_m = 458000.1234;
  const ExportCloud cloud{{{east_m, 0, 0}}, {{"points", {7}}}};
  const std::string ply = cloud_file(cloud, CloudFormat::ply);
  EXPECT_THAT(ply, HasSubstr("element vertex 1\nproperty double x\n"));
  const std::size_t data = data_of(ply, "end_header\n");
  ASSERT_EQ(ply.size(), data + 28);
  EXPECT_EQ(number_at<double>(ply, data), east_m);
  EXPECT_EQ(number_at<std::uint32_t>(ply, data + 24), 7U);
  EXPECT_THAT(cloud_file(cloud, CloudFormat::pcd), HasSubstr("SIZE 8 8 8 4\n"));
}

// Offsets of LAS 1.4-R15, tables 3, 5 and 15.
TEST(CloudFile, LasHasStepsFromTheFirstPointAndColumnsAsExtraBytes) {
  const ExportCloud cloud{{{458000.2, 2, 3}, {458000.25, -5.5, 6}},
                          {{"label", {9, 251}}, {"object", {0, 7}}}};
  const std::string bytes = cloud_file(cloud, CloudFormat::las);
  EXPECT_EQ(bytes.substr(0, 4), "LASF");
  EXPECT_EQ(bytes.substr(24, 2), std::string("\1\4"));
  EXPECT_EQ(number_at<std::uint16_t>(bytes, 94), 375);
  const auto data = number_at<std::uint32_t>(bytes, 96);
  EXPECT_EQ(data, 375U + 54 + 2 * 192);
  EXPECT_EQ(number_at<std::uint8_t>(bytes, 104), 6);
  EXPECT_EQ(number_at<std::uint16_t>(bytes, 105), 38);
  EXPECT_EQ(number_at<double>(bytes, 131), 1e-4);
  EXPECT_EQ(number_at<double>(bytes, 155), 458000);
  EXPECT_EQ(number_at<double>(bytes, 179), 458000.25);  // largest x
  EXPECT_EQ(number_at<double>(bytes, 203), -5.5);       // smallest y
  EXPECT_EQ(number_at<std::uint64_t>(bytes, 247), 2U);
  EXPECT_EQ(bytes.substr(375 + 54 + 192 + 4, 6), "object");
  ASSERT_EQ(bytes.size(), data + 2 * 38);
  EXPECT_EQ(number_at<std::int32_t>(bytes, data), 2000);
  EXPECT_EQ(number_at<std::int32_t>(bytes, data + 38 + 4), -75000);
  EXPECT_EQ(number_at<std::uint32_t>(bytes, data + 38 + 30), 251U);
  EXPECT_EQ(number_at<std::uint32_t>(bytes, data + 38 + 34), 7U);
}

// int32 in steps of 0.1 mm ends at 214.7 km.
TEST(CloudFile, LasTakesCoarserStepsForAWideCloud) {
  const std::string bytes = cloud_file({{{0, 0, 0}, {300000, 0, 0}}, {}}, CloudFormat::las);
  EXPECT_DOUBLE_EQ(number_at<double>(bytes, 131), 1e-3);
  EXPECT_EQ(number_at<std::int32_t>(bytes, 375 + 30), 300000000);
}

TEST(CloudFile, TheEndingOfTheNameIsTheFormat) {
  const test::TemporaryFolder folder;
  const ExportCloud cloud{{{1, 2, 3}}, {}};
  for (const auto& [name, format] :
       {std::pair("a.pcd", CloudFormat::pcd), {"a.ply", CloudFormat::ply}, {"a.las", CloudFormat::las}}) {
    write_cloud_file(folder.path() / name, cloud);
    EXPECT_EQ(read_whole_file(folder.path() / name), cloud_file(cloud, format));
  }
  for (const char* name : {"a.xyz", "a", "pcd", "a.PCD"})
    EXPECT_THROW((void)cloud_format_of(name), ParameterError) << name;
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
