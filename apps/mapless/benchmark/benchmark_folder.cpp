#include "benchmark/benchmark_folder.hpp"

#include <system_error>

#include "reports/digest.hpp"
#include "reports/json.hpp"
#include "reports/json_text.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::app {
namespace {

namespace fs = std::filesystem;
[[noreturn]] void refuse(const fs::path& folder, const std::string& problem) {
  throw OutputError(
      {folder.string(), "", "", problem, "choose a new folder, or one of an earlier benchmark"});
}

// A row that was changed or damaged since is not of this run, and is run again.
std::string digest_of(const Json& result) {
  Digest digest;
  digest.add_bytes(result.dump());
  return digest.text();
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) refuse(folder, "cannot be made: " + error.message());
}

}  // namespace

void BenchmarkFolder::open() const {
  std::error_code error;
  const bool is_there = fs::exists(path_, error);
  if (error) refuse(path_, error.message());
  if (is_there && !fs::is_directory(path_)) refuse(path_, "is not a folder");
  const bool is_empty = !is_there || fs::is_empty(path_, error);
  if (error) refuse(path_, error.message());
  if (!is_empty &&
      (!fs::is_regular_file(figures()) || !read_whole_file(figures()).starts_with(kBenchmarkBegin)))
    refuse(path_, "holds files that are not of a benchmark");
  make_folder(path_);
  if (is_empty) {
    write_file_atomically(figures(), json_text({{"program", kBenchmarkName}, {"complete", false}}));
  }
  for (const fs::path& folder : {path_ / "rows", pictures(), plots(), views()}) make_folder(folder);
}

fs::path BenchmarkFolder::row_file(const std::string& stem) const {
  return path_ / "rows" / (stem + ".json");
}

Json BenchmarkFolder::row_head(const Json& job) const { return {{"build", build_}, {"job", job}}; }

std::optional<Json> BenchmarkFolder::finished(const std::string& stem, const Json& job) const {
  if (!fs::is_regular_file(row_file(stem))) return std::nullopt;
  const Json row = Json::parse(read_whole_file(row_file(stem)), nullptr, false);
  if (!row.is_object() || !row.contains("result") || !row.contains("digest") ||
      row["digest"] != digest_of(row["result"]))
    return std::nullopt;
  // Compared as text: a number read from a file may have another JSON type and the same value.
  const Json head = row_head(job);
  for (const char* key : {"build", "job"}) {
    if (!row.contains(key) || row[key].dump() != head[key].dump()) return std::nullopt;
  }
  for (const Json& picture : row["result"].value("pictures", Json::array())) {
    if (!fs::is_regular_file(pictures() / picture.value("file", "?"))) return std::nullopt;
  }
  const std::string view = row["result"].value("view", "");
  if (!view.empty() && !fs::is_regular_file(views() / view)) return std::nullopt;
  return std::make_optional<Json>(row["result"]);  // nlohmann-json 3.10 takes a conversion for ambiguous
}

void BenchmarkFolder::finish(const std::string& stem, const Json& job, const Json& result) const {
  Json row = row_head(job);
  row["digest"] = digest_of(result);
  row["result"] = result;
  write_file_atomically(row_file(stem), json_text(row));
}

std::string build_digest() {
  Digest digest;
  digest.add_bytes(read_whole_file("/proc/self/exe"));
  return digest.text();
}

}  // namespace mapless::app
