#include <algorithm>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <mapless/core/errors.hpp>
#include <mapless/io/files.hpp>

namespace mapless::inline v1 {
namespace {

using References = std::vector<ParameterReference>;

std::string place(const std::string& file, const YAML::Mark& mark) {
  return mark.is_null() ? file : fmt::format("{}:{}", file, mark.line + 1);
}

bool is_group(const References& parameters, const std::string& prefix) {
  return std::any_of(parameters.begin(), parameters.end(),
                     [&](const ParameterReference& p) { return p.key.starts_with(prefix); });
}

[[noreturn]] void refuse_map(const std::string& where, const std::string& key) {
  throw ParameterError({where, key, "", "must be a map of parameter names to values",
                        "see 'mapless config' for the keys there are"});
}

void read_map(const YAML::Node& map, const std::string& file, const std::string& prefix,
              const References& parameters) {
  std::set<std::string> seen;
  for (const auto& entry : map) {
    const std::string where = place(file, entry.first.Mark());
    if (!entry.first.IsScalar()) refuse_map(where, prefix);
    const std::string key = prefix + entry.first.Scalar();
    if (!seen.insert(key).second) {
      throw ParameterError({where, key, "", "is given twice", "keep one of the two"});
    }
    // Only names that begin a known key are descended into, so an alias to itself ends at the depth of the
    // keys.
    if (is_group(parameters, key + ".")) {
      if (!entry.second.IsMap()) refuse_map(where, key);
      read_map(entry.second, file, key + ".", parameters);
    } else {
      assign_parameter(parameters, key,
                       entry.second.IsScalar() ? entry.second.Scalar() : YAML::Dump(entry.second), where);
    }
  }
}

std::string bounds_text(const ParameterReference& p) {
  const std::string_view type = p.type();
  if (type == "switch") return "true or false";
  if (type == "choice") {
    return fmt::format("{}", fmt::join(std::get<ChoiceReference>(p.value).names, " or "));
  }
  std::string text = fmt::format("{}{} to {}", p.odd ? "odd, " : "", p.min, p.max);
  if (!p.unit.empty()) text += fmt::format(" {}", p.unit);
  return text;
}

void append_comment(std::string& out, const std::string& indent, std::string_view text) {
  constexpr std::size_t kWidth = 100;
  std::string line;
  const auto end_line = [&] { out += fmt::format("{}# {}\n", indent, line); };
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word(text.substr(begin, end - begin));
    if (!line.empty() && indent.size() + line.size() + word.size() > kWidth) {
      end_line();
      line.clear();
    }
    line += line.empty() ? word : " " + word;
    begin = end + 1;
  }
  end_line();
}

}  // namespace

void read_parameters_file(const std::filesystem::path& file, const References& parameters) {
  YAML::Node root;
  try {
    root = YAML::Load(read_whole_file(file));
  } catch (const YAML::Exception& error) {
    throw InputError({place(file.string(), error.mark), "", "", "is not YAML: " + error.msg,
                      "see 'mapless config' for how a configuration is written"});
  }
  if (root.IsNull()) return;
  if (!root.IsMap()) refuse_map(file.string(), "");
  read_map(root, file.string(), "", parameters);
}

std::string parameters_yaml(const References& parameters, const References& defaults) {
  std::string out;
  std::string group;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const ParameterReference& p = parameters[i];
    const std::size_t dot = p.key.rfind('.');
    const std::string own_group = dot == std::string::npos ? "" : p.key.substr(0, dot);
    const std::string indent = own_group.empty() ? "" : "  ";
    if (own_group != group) out += fmt::format("\n{}:\n", own_group);
    group = own_group;
    append_comment(out, indent, p.help);
    append_comment(out, indent,
                   fmt::format("[{}; default {}; {}]", bounds_text(p), defaults[i].text(), p.source));
    out += fmt::format("{}{}: {}\n", indent, p.key.substr(dot + 1), p.text());
  }
  return out;
}

}  // namespace mapless
