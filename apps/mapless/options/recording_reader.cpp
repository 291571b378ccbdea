#include "options/recording_reader.hpp"

#include <utility>

namespace mapless::app {
namespace {

RecordingReader& current_reader() {
  static RecordingReader reader;
  return reader;
}

}  // namespace

void set_recording_reader(RecordingReader reader) { current_reader() = std::move(reader); }
const RecordingReader& recording_reader() { return current_reader(); }

}  // namespace mapless::app
