#include <cstdlib>
#include <iostream>

#include "fuzz/readers.hpp"
#include "support/temporary_folder.hpp"
#include <mapless/io/files.hpp>

// The entry points of libFuzzer. MAPLESS_READER names the reader; scripts/fuzz.sh runs one after the other.

namespace {

struct Run {
  mapless::test::TemporaryFolder folder;
  const mapless::fuzz::Reader* reader = nullptr;
};

Run& run() {
  static Run the_run;
  return the_run;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  const char* name = std::getenv("MAPLESS_READER");
  const std::string wanted = name == nullptr ? "" : name;
  for (const mapless::fuzz::Reader& reader : mapless::fuzz::readers()) {
    if (wanted.empty()) std::cout << reader.name << ' ' << reader.dictionary << '\n';
    if (reader.name == wanted) run().reader = &reader;
  }
  if (wanted.empty()) std::exit(0);
  if (run().reader == nullptr) {
    std::cerr << "MAPLESS_READER=" << wanted << ": no such reader\n";
    std::exit(2);
  }
  run().reader->write(run().folder.path());
  // The file as its writer makes it is the first of the corpus.
  if (const char* seed = std::getenv("MAPLESS_SEED")) {
    mapless::write_file_atomically(seed, mapless::read_whole_file(run().folder.path() / run().reader->file));
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  (void)mapless::fuzz::refusal(*run().reader, run().folder.path(), bytes);
  return 0;
}
