#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace mapless::inline v1 {

/// One field of a point cloud file: `count` numbers of one type per point.
struct PcdField {
  std::string name;
  char type = 'F';       ///< 'I' signed, 'U' unsigned, 'F' floating
  std::size_t size = 4;  ///< bytes of one number: 1, 2, 4 or 8
  std::size_t count = 1;
  std::size_t offset = 0;  ///< of its first byte in a point

  [[nodiscard]] bool is_floating() const { return type == 'F'; }
};

/// A point cloud file (PCD 0.7, pcl::io) with any fields. Points are stored one after the other, row by row.
struct PcdCloud {
  std::filesystem::path file;  ///< for messages
  std::size_t width = 0;
  std::size_t height = 0;
  std::size_t stride = 0;  ///< bytes of a point
  std::vector<PcdField> fields;
  std::string bytes;  ///< size() x stride

  [[nodiscard]] std::size_t size() const { return width * height; }
  /// Appends a field; only while `bytes` is empty.
  void add_field(std::string name, char type, std::size_t size, std::size_t count = 1);
  /// The first field of this name; null if there is none.
  [[nodiscard]] const PcdField* find(std::string_view name) const;
  /// The first field of this name; throws InputError if there is none.
  [[nodiscard]] const PcdField& require(std::string_view name) const;
  /// The first number of a field, for every point.
  [[nodiscard]] std::vector<float> floats(const PcdField& field) const;
  /// The first number of a field as an integer, exactly. Throws InputError for a value that is no 64-bit
  /// integer.
  [[nodiscard]] std::vector<std::int64_t> integers(const PcdField& field) const;
};

/// Reads DATA ascii, binary and binary_compressed. Throws InputError naming file, field and value for an
/// invalid header, and for a body of another length than the header states.
[[nodiscard]] PcdCloud read_pcd(const std::filesystem::path& file);

/// Writes DATA binary, atomically. Throws OutputError.
void write_pcd(const std::filesystem::path& file, const PcdCloud& cloud);

/// Decompresses LZF (liblzf); false if the input does not give `size` bytes.
[[nodiscard]] bool lzf_decompress(std::string_view in, std::size_t size, std::string& out);

}  // namespace mapless
