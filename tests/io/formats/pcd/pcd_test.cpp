#include "io/formats/pcd/pcd.hpp"

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless {
namespace MAPLESS_FILE {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kHeader =
    "# comment\nVERSION .7\nFIELDS x y z ring t\nSIZE 4 4 8 2 4\nTYPE F F F U U\nCOUNT 1 1 1 1 1\nWIDTH "
    "2\nHEIGHT 1\n"
    "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\n";
constexpr const char* kAsciiBody = "DATA ascii\n1 2 3.25 63 4000000000\nnan -inf -1e-3 0 7\n";

PcdCloud cloud_of(const std::string& text) {
  const test::TemporaryFolder folder;
  write_file_atomically(folder / "a.pcd", text);
  return read_pcd(folder / "a.pcd");
}

std::string refusal(const std::string& text) {
  try {
    (void)cloud_of(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

std::string binary_body() {
  std::string bytes = "DATA binary\n";
  for (const auto& [x, y, z, ring, t] :
       {std::tuple{1.0f, 2.0f, 3.25, 63, 4000000000u}, {4.0f, 5.0f, 6.5, 0, 7u}}) {
    append(bytes, x);
    append(bytes, y);
    append(bytes, z);
    append(bytes, static_cast<std::uint16_t>(ring));
    append(bytes, t);
  }
  return bytes;
}

TEST(Pcd, ReadsAscii) {
  const PcdCloud cloud = cloud_of(std::string(kHeader) + kAsciiBody);
  EXPECT_EQ(cloud.width, 2u);
  EXPECT_EQ(cloud.height, 1u);
  EXPECT_THAT(cloud.floats(cloud.require("z")), ElementsAre(3.25F, -1e-3F));
  EXPECT_THAT(cloud.integers(cloud.require("ring")), ElementsAre(63, 0));
  EXPECT_THAT(cloud.integers(cloud.require("t")), ElementsAre(4'000'000'000, 7));
  EXPECT_TRUE(std::isnan(cloud.floats(cloud.require("x"))[1]));
  EXPECT_EQ(cloud.floats(cloud.require("y"))[1], -std::numeric_limits<float>::infinity());
  EXPECT_EQ(cloud.find("intensity"), nullptr);
}

TEST(Pcd, ReadsBinary) {
  const PcdCloud cloud = cloud_of(kHeader + binary_body());
  EXPECT_THAT(cloud.floats(cloud.require("x")), ElementsAre(1, 4));
  EXPECT_THAT(cloud.floats(cloud.require("z")), ElementsAre(3.25F, 6.5F));
  EXPECT_THAT(cloud.integers(cloud.require("ring")), ElementsAre(63, 0));
  EXPECT_THAT(cloud.integers(cloud.require("t")), ElementsAre(4'000'000'000, 7));
}

TEST(Pcd, ReadsCompressed) {
  const std::string header =
      replaced(replaced(kHeader, "x y z ring t", "x y z ring t"), "COUNT 1 1 1 1 1\n", "");
  std::string by_field;
  for (const float x : {1.0f, 4.0f, 2.0f, 5.0f}) append(by_field, x);
  for (const double z : {3.25, 6.5}) append(by_field, z);
  for (const std::uint16_t ring : {std::uint16_t{63}, std::uint16_t{0}}) append(by_field, ring);
  for (const std::uint32_t t : {4'000'000'000u, 7u}) append(by_field, t);
  // One run of 32 literal bytes and one of 12: what LZF does with bytes that do not repeat.
  ASSERT_EQ(by_field.size(), 44u);
  const std::string packed =
      std::string(1, 31) + by_field.substr(0, 32) + std::string(1, 11) + by_field.substr(32);
  std::string sizes;
  append(sizes, static_cast<std::uint32_t>(packed.size()));
  append(sizes, static_cast<std::uint32_t>(by_field.size()));
  const std::string text = header + "DATA binary_compressed\n" + sizes + packed;
  const PcdCloud cloud = cloud_of(text);
  EXPECT_THAT(cloud.floats(cloud.require("y")), ElementsAre(2, 5));
  EXPECT_THAT(cloud.floats(cloud.require("z")), ElementsAre(3.25F, 6.5F));
  EXPECT_THAT(cloud.integers(cloud.require("t")), ElementsAre(4'000'000'000, 7));
  EXPECT_THAT(refusal(text.substr(0, text.size() - 1)), HasSubstr("cut off or damaged"));
  EXPECT_THAT(refusal(header + "DATA binary_compressed\n1234"), HasSubstr("DATA = 4 bytes"));
  EXPECT_THAT(refusal(replaced(text, "WIDTH 2", "WIDTH 3").replace(text.find("POINTS 2"), 8, "POINTS 3")),
              HasSubstr("44 bytes uncompressed"));
}

TEST(Pcd, LzfHandlesOverlappingCopiesAndStaysWithinBounds) {
  std::string out;
  // "ab", then 6 bytes from 2 back, then 7 + 3 + 2 = 12 bytes from 1 back.
  const std::string in(
      "\x01"
      "ab"
      "\x80\x01"
      "\xe0\x03\x00",
      8);
  EXPECT_TRUE(lzf_decompress(in, 20, out));
  EXPECT_EQ(out, "abababab" + std::string(12, 'b'));
  EXPECT_FALSE(lzf_decompress(in, 19, out));
  EXPECT_FALSE(lzf_decompress(in, 21, out));
  EXPECT_FALSE(lzf_decompress(std::string_view(in).substr(0, 7), 20, out));
  EXPECT_FALSE(lzf_decompress(std::string("\x20\x05", 2), 3, out));
  // A size that no input can give is refused before memory is allocated.
  EXPECT_FALSE(lzf_decompress(in, std::size_t{1} << 60, out));
  std::mt19937 rng(3);
  for (int i = 0; i < 2000; ++i) {
    std::string noise(rng() % 40, '\0');
    for (char& c : noise) c = static_cast<char>(rng());
    (void)lzf_decompress(noise, rng() % 100, out);
  }
}

TEST(Pcd, WrittenCloudsReadBack) {
  const test::TemporaryFolder folder;
  PcdCloud cloud;
  cloud.width = 2;
  cloud.height = 3;
  cloud.add_field("x", 'F', 4);
  cloud.add_field("normal", 'F', 8, 3);
  cloud.add_field("code", 'U', 1);
  cloud.bytes.resize(6 * cloud.stride);
  for (std::size_t i = 0; i < cloud.bytes.size(); ++i) cloud.bytes[i] = static_cast<char>(i);
  write_pcd(folder / "a.pcd", cloud);
  const PcdCloud back = read_pcd(folder / "a.pcd");
  EXPECT_EQ(back.bytes, cloud.bytes);
  EXPECT_EQ(back.width, 2u);
  EXPECT_EQ(back.height, 3u);
  ASSERT_EQ(back.fields.size(), 3u);
  EXPECT_EQ(back.fields[2].offset, 28u);
  EXPECT_EQ(back.integers(back.require("code"))[1], 29 + 28);
}

TEST(Pcd, IntegersAreExactOrRefused) {
  const std::string header =
      "VERSION 0.7\nFIELDS a b\nSIZE 8 4\nTYPE U F\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n";
  const PcdCloud good = cloud_of(header + "9007199254740993 5\n");
  EXPECT_THAT(good.integers(good.require("a")), ElementsAre(9007199254740993));
  EXPECT_THAT(good.integers(good.require("b")), ElementsAre(5));
  for (const char* row : {"18446744073709551615 5.5\n", "18446744073709551615 nan\n"}) {
    const PcdCloud bad = cloud_of(header + row);
    EXPECT_THROW((void)bad.integers(bad.require("a")), InputError);
    EXPECT_THROW((void)bad.integers(bad.require("b")), InputError);
  }
}

TEST(Pcd, BadHeadersNameFileKeyAndValue) {
  const auto broken = [](const std::string& from, const std::string& to) {
    return refusal(replaced(std::string(kHeader) + kAsciiBody, from, to));
  };
  EXPECT_EQ(refusal(std::string(kHeader) + kAsciiBody), "accepted");
  EXPECT_THAT(refusal(""), AllOf(HasSubstr("a.pcd"), HasSubstr("0 bytes"), HasSubstr("empty")));
  EXPECT_THAT(refusal(kHeader), HasSubstr("DATA: missing"));
  EXPECT_THAT(refusal(std::string("\x89PNG\r\n\x1a\n\0\0", 10)), HasSubstr("not a key of a PCD header"));
  EXPECT_THAT(broken("VERSION .7", "VERSION 0.6"), HasSubstr("VERSION = 0.6"));
  EXPECT_THAT(broken("WIDTH 2\n", ""), HasSubstr("WIDTH: missing"));
  EXPECT_THAT(broken("WIDTH 2", "WIDTH two"), HasSubstr("WIDTH = two"));
  EXPECT_THAT(broken("WIDTH 2", "WIDTH -2"), HasSubstr("WIDTH = -2"));
  EXPECT_THAT(broken("WIDTH 2", "WIDTH 4294967296"), HasSubstr("WIDTH = 4294967296"));
  EXPECT_THAT(broken("WIDTH 2", "WIDTH 2\nWIDTH 2"), HasSubstr("WIDTH: there twice"));
  EXPECT_THAT(broken("WIDTH 2", "BREADTH 2"), HasSubstr("BREADTH"));
  EXPECT_THAT(broken("POINTS 2", "POINTS 3"), AllOf(HasSubstr("POINTS = 3"), HasSubstr("2 x 1")));
  EXPECT_THAT(broken("SIZE 4", "SIZE 3"), HasSubstr("SIZE = 3"));
  EXPECT_THAT(broken("SIZE 4 4 8 2 4", "SIZE 4 4 8 2"), HasSubstr("SIZE = 4 values"));
  EXPECT_THAT(broken("TYPE F", "TYPE X"), HasSubstr("TYPE = X"));
  EXPECT_THAT(broken("TYPE F F F U", "TYPE F F F F"), HasSubstr("SIZE = 2"));
  EXPECT_THAT(broken("COUNT 1", "COUNT 99999999"), HasSubstr("COUNT = 99999999"));
  // A field without a value would be read from beyond the last point.
  EXPECT_THAT(broken("COUNT 1 1 1 1 1", "COUNT 1 1 1 1 0"), HasSubstr("COUNT = 0: not an integer from 1"));
  EXPECT_THAT(broken("FIELDS x y z ring t", "FIELDS"), HasSubstr("FIELDS: none"));
  EXPECT_THAT(broken("DATA ascii", "DATA hex"), HasSubstr("DATA = hex"));
}

// 4,000 rows of one number each, of points of 512 kB: 2 GB where the header is believed.
TEST(Pcd, AsciiBodiesHaveRoomForTheirNumbers) {
  const test::TemporaryFolder folder;
  std::string text =
      "VERSION 0.7\nFIELDS x\nSIZE 8\nTYPE F\nCOUNT 65536\nWIDTH 4000\nHEIGHT 1\nPOINTS 4000\nDATA ascii\n";
  for (int i = 0; i < 4000; ++i) text += "1\n";
  write_file_atomically(folder / "f.pcd", text);
  try {
    (void)read_pcd(folder / "f.pcd");
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("no room for 4000 points of 65536 numbers"), std::string::npos);
  }
}

// 195,225,786 points of 22 bytes: 4.3 GB of 12 bytes.
TEST(Pcd, CompressedBodiesThatClaimGigabytesAreRefused) {
  std::string text =
      replaced(replaced(kHeader, "WIDTH 2", "WIDTH 195225786"), "POINTS 2", "POINTS 195225786");
  text += "DATA binary_compressed\n";
  append(text, std::uint32_t{12});
  append(text, std::uint32_t{4294967292});
  EXPECT_THAT(refusal(text + "\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff"),
              HasSubstr("12 bytes compressed"));
}

TEST(Pcd, TruncatedBodiesAreRefused) {
  const std::string ascii = std::string(kHeader) + kAsciiBody, binary = kHeader + binary_body();
  EXPECT_EQ(refusal(binary), "accepted");
  EXPECT_THAT(refusal(binary.substr(0, binary.size() - 1)),
              AllOf(HasSubstr("DATA = 43 bytes"), HasSubstr("2 x 22")));
  EXPECT_THAT(refusal(binary + std::string(22, 'x')), HasSubstr("DATA = 66 bytes"));
  EXPECT_THAT(
      refusal(replaced(replaced(binary, "WIDTH 2", "WIDTH 268435456"), "POINTS 2", "POINTS 268435456")),
      HasSubstr("44 bytes"));
  EXPECT_THAT(refusal(replaced(ascii, "nan -inf -1e-3 0 7\n", "")), HasSubstr("DATA = 1 rows"));
  EXPECT_THAT(refusal(replaced(ascii, " 0 7\n", " 0\n")), HasSubstr("point 1 t: missing"));
  EXPECT_THAT(refusal(replaced(ascii, " 0 7\n", " 0 7 8\n")), HasSubstr("point 1 = 6 values"));
  EXPECT_THAT(refusal(replaced(ascii, " 63 ", " 65536 ")), HasSubstr("point 0 ring = 65536: not of type U2"));
  EXPECT_THAT(refusal(replaced(ascii, "1 2 3.25", "one 2 3.25")), HasSubstr("point 0 x = one"));
}

}  // namespace MAPLESS_FILE
}  // namespace mapless
