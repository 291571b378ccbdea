#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <variant>
#include <vector>

namespace mapless::inline v1 {

/// The declaration of one parameter: the only place its name, unit, bounds, meaning and source are written;
/// the default is the member's initialiser. The configuration reader, `--set`, the dumped configuration,
/// `mapless config` and its schema all come from these declarations.
///
/// A parameter struct `P` lists its members as
///
///     static constexpr auto declarations() {
///       return std::tuple{declare(&P::scan_gap, "scan_gap", "scans", 1, 100, "...", "paper step 2"), ...};
///     }
///
/// A member that is itself such a struct is declared with `group`. A choice is an enum with an overload
/// `choice_names(Enum)` that returns the names of its values 0, 1, 2 ...
template <class Struct, class Value>
struct ParameterDeclaration {
  Value Struct::*member;
  std::string_view name;
  std::string_view unit;  ///< empty for a count, a switch or a choice
  double min;             ///< inclusive; unused for switches and choices
  double max;             ///< inclusive
  std::string_view help;
  std::string_view source;  ///< paper section or equation, or "method.md 2" where the paper is silent
  bool odd = false;         ///< an integer that must be odd
};

template <class Struct, class Group>
struct ParameterGroup {
  Group Struct::*member;
  std::string_view name;
};

template <class Struct, class Value>
constexpr ParameterDeclaration<Struct, Value> declare(Value Struct::*member, std::string_view name,
                                                      std::string_view unit, double min, double max,
                                                      std::string_view help, std::string_view source) {
  return {member, name, unit, min, max, help, source};
}

template <class Struct, class Value>
constexpr ParameterDeclaration<Struct, Value> declare(Value Struct::*member, std::string_view name,
                                                      std::string_view help, std::string_view source) {
  return {member, name, "", 0, 0, help, source};
}

/// The side of a window that has a middle: an odd integer.
template <class Struct>
constexpr ParameterDeclaration<Struct, int> declare_odd(int Struct::*member, std::string_view name,
                                                        std::string_view unit, double min, double max,
                                                        std::string_view help, std::string_view source) {
  return {member, name, unit, min, max, help, source, true};
}

template <class Struct, class Group>
constexpr ParameterGroup<Struct, Group> group(Group Struct::*member, std::string_view name) {
  return {member, name};
}

/// A choice seen without its type.
struct ChoiceReference {
  std::span<const std::string_view> names;
  std::function<int()> get;
  std::function<void(int)> set;
};

/// One parameter of a live struct, seen without its type. Valid as long as the struct is.
struct ParameterReference {
  std::string key;  ///< "freespace.border_threshold_m"
  std::string_view unit;
  double min;
  double max;
  std::string_view help;
  std::string_view source;
  std::variant<bool*, int*, double*, ChoiceReference> value;
  bool odd = false;

  /// The value as the configuration file and the command line write it.
  [[nodiscard]] std::string text() const;
  /// Sets the value from text. Throws ParameterError naming `where`, the key, the text and the bounds.
  void assign(std::string_view text, const std::string& where) const;
  /// Throws ParameterError naming `where`, the key, the value and the bounds if the value is out of bounds
  /// (NaN is), even where it must be odd, or none of its choices.
  void require_within_bounds(const std::string& where) const;
  /// "switch", "integer", "number" or "choice".
  [[nodiscard]] std::string_view type() const;
};

namespace detail {

template <class Value>
std::variant<bool*, int*, double*, ChoiceReference> reference(Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    return ChoiceReference{choice_names(value), [&value] { return static_cast<int>(value); },
                           [&value](int i) { value = static_cast<Value>(i); }};
  } else {
    return &value;
  }
}

template <class Struct>
void collect(Struct& parameters, const std::string& prefix, std::vector<ParameterReference>& out);

template <class Struct, class Value>
void collect_one(Struct& p, const ParameterDeclaration<Struct, Value>& d, const std::string& prefix,
                 std::vector<ParameterReference>& out) {
  out.push_back({prefix + std::string(d.name), d.unit, d.min, d.max, d.help, d.source,
                 reference(p.*(d.member)), d.odd});
}

template <class Struct, class Group>
void collect_one(Struct& p, const ParameterGroup<Struct, Group>& g, const std::string& prefix,
                 std::vector<ParameterReference>& out) {
  collect(p.*(g.member), prefix + std::string(g.name) + ".", out);
}

template <class Struct>
void collect(Struct& parameters, const std::string& prefix, std::vector<ParameterReference>& out) {
  std::apply([&](const auto&... d) { (collect_one(parameters, d, prefix, out), ...); },
             Struct::declarations());
}

}  // namespace detail

/// Every parameter of `parameters`, groups flattened, in the order of declaration.
template <class Struct>
[[nodiscard]] std::vector<ParameterReference> parameter_references(Struct& parameters) {
  std::vector<ParameterReference> out;
  detail::collect(parameters, "", out);
  return out;
}

/// Checks every parameter of `parameters` against its declaration; public constructors that take a parameter
/// struct call this first. Throws ParameterError for the first that is out of bounds, see
/// ParameterReference::require_within_bounds; `where` names the constructor or function, e.g. "Detector".
template <class Struct>
void require_within_bounds(const Struct& parameters, const std::string& where) {
  Struct copy = parameters;  // references are to what can be assigned
  for (const ParameterReference& parameter : parameter_references(copy))
    parameter.require_within_bounds(where);
}

/// Sets `key` from `text`. Throws ParameterError naming `where` for an unknown key (with the nearest known
/// one), a text that is not a value of its type, or a value out of bounds.
void assign_parameter(const std::vector<ParameterReference>& parameters, std::string_view key,
                      std::string_view text, const std::string& where);

}  // namespace mapless
