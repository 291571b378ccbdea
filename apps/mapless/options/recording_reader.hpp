#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <mapless/io/dataset.hpp>

namespace mapless::app {

/// Reads recordings that the library does not: the Python package adds bags and packet captures to the
/// command in this way. The verbs open every recording through it.
struct RecordingReader {
  struct Option {
    std::string flag;  ///< "--topic"
    std::string help;
  };

  std::vector<std::string> formats;  ///< names for --format, beside those of the library
  std::vector<Option> options;       ///< added to every verb that reads a recording; each takes a text
  /// Opens `path` with the options that were given, by flag; null where the recording is none of `formats`.
  std::function<std::unique_ptr<Dataset>(const std::filesystem::path& path, const DatasetOptions&,
                                         const std::map<std::string, std::string>& given)>
      open;
};

/// The reader that the verbs use beside the library's own; without `open` until it is set.
void set_recording_reader(RecordingReader reader);
[[nodiscard]] const RecordingReader& recording_reader();

}  // namespace mapless::app
