#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include <fmt/format.h>

#include "core/number_text.hpp"
#include <mapless/core/errors.hpp>
#include <mapless/core/parameters.hpp>

namespace mapless::inline v1 {
namespace {

std::optional<bool> parse_switch(std::string_view text) {
  if (text == "true" || text == "on" || text == "yes") return true;
  if (text == "false" || text == "off" || text == "no") return false;
  return std::nullopt;
}

std::string with_unit(const ParameterReference& p) {
  return p.unit.empty() ? std::string() : fmt::format(" {}", p.unit);
}

std::string bounds(const ParameterReference& p) {
  return fmt::format("give {} from {} to {}{}", p.odd ? "an odd number" : "a value", p.min, p.max,
                     with_unit(p));
}

// What is wrong with a number, or empty. Written so that NaN is out of bounds.
std::string_view problem_of(const ParameterReference& p, double number) {
  if (!(number >= p.min && number <= p.max)) return "out of bounds";
  if (p.odd && std::fmod(number, 2) == 0) return "not odd";
  return {};
}

// Levenshtein distance.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t above = row[j + 1];
      row[j + 1] = std::min({above + 1, row[j] + 1, diagonal + (a[i] == b[j] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row.back();
}

// A key typed without its group is as near as the key's last part.
std::size_t key_distance(std::string_view typed, std::string_view key) {
  const std::size_t dot = key.rfind('.');
  const std::string_view leaf = dot == std::string_view::npos ? key : key.substr(dot + 1);
  return std::min(edit_distance(typed, key), edit_distance(typed, leaf));
}

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <class... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

}  // namespace

std::string ParameterReference::text() const {
  return std::visit(Overloaded{[](const bool* v) { return std::string(*v ? "true" : "false"); },
                               [](const int* v) { return std::to_string(*v); },
                               [](const double* v) { return fmt::format("{}", *v); },
                               [](const ChoiceReference& c) {
                                 return std::string(c.names[static_cast<std::size_t>(c.get())]);
                               }},
                    value);
}

void ParameterReference::assign(std::string_view text, const std::string& where) const {
  const auto refuse = [&](const std::string& problem, const std::string& remedy) {
    throw ParameterError({where, key, std::string(text), problem, remedy});
  };
  const auto assign_number = [&](auto* target, std::string_view kind) {
    const auto number = parse_number<std::remove_reference_t<decltype(*target)>>(text);
    if (!number) return refuse(fmt::format("not {}", kind), bounds(*this));
    const std::string_view problem = problem_of(*this, static_cast<double>(*number));
    if (!problem.empty()) return refuse(std::string(problem), bounds(*this));
    *target = *number;
  };
  const auto assign_choice = [&](const ChoiceReference& choice) {
    const auto found = std::find(choice.names.begin(), choice.names.end(), text);
    if (found == choice.names.end()) {
      return refuse("not one of its choices", fmt::format("choose {}", fmt::join(choice.names, ", ")));
    }
    choice.set(static_cast<int>(found - choice.names.begin()));
  };
  const auto assign_switch = [&](bool* target) {
    const std::optional<bool> on = parse_switch(text);
    if (!on) return refuse("not a switch", "give true or false");
    *target = *on;
  };
  std::visit(Overloaded{assign_switch, [&](int* v) { assign_number(v, "an integer"); },
                        [&](double* v) { assign_number(v, "a number"); }, assign_choice},
             value);
}

void ParameterReference::require_within_bounds(const std::string& where) const {
  const auto require_number = [&](const auto* v) {
    const std::string_view problem = problem_of(*this, static_cast<double>(*v));
    if (!problem.empty()) throw ParameterError({where, key, text(), std::string(problem), bounds(*this)});
  };
  const auto require_choice = [&](const ChoiceReference& choice) {
    const int i = choice.get();
    if (i >= 0 && i < static_cast<int>(choice.names.size())) return;
    throw ParameterError({where, key, std::to_string(i), "not one of its choices",
                          fmt::format("choose {}", fmt::join(choice.names, ", "))});
  };
  std::visit(Overloaded{[](const bool*) {}, require_number, require_choice}, value);
}

std::string_view ParameterReference::type() const {
  return std::visit(
      Overloaded{[](const bool*) { return "switch"; }, [](const int*) { return "integer"; },
                 [](const double*) { return "number"; }, [](const ChoiceReference&) { return "choice"; }},
      value);
}

void assign_parameter(const std::vector<ParameterReference>& parameters, std::string_view key,
                      std::string_view text, const std::string& where) {
  const auto nearer = [key](const ParameterReference& a, const ParameterReference& b) {
    return key_distance(key, a.key) < key_distance(key, b.key);
  };
  const auto found = std::find_if(parameters.begin(), parameters.end(),
                                  [key](const ParameterReference& p) { return p.key == key; });
  if (found != parameters.end()) return found->assign(text, where);
  const auto nearest = std::min_element(parameters.begin(), parameters.end(), nearer);
  throw ParameterError({where, std::string(key), std::string(text), "unknown parameter",
                        nearest == parameters.end() ? "there are no parameters"
                                                    : fmt::format("did you mean {}?", nearest->key)});
}

}  // namespace mapless
