#pragma once

#include <stdexcept>
#include <string>

/// The library hides its symbols; an exception that leaves a shared library is caught by its type, which
/// shows.
#define MAPLESS_EXCEPTION __attribute__((visibility("default")))

namespace mapless::inline v1 {

/// What went wrong with one thing from outside. Every part may be empty except `problem`.
struct ErrorDetail {
  std::string where;    ///< file (with line or scan where known), option or parameter
  std::string field;    ///< the field in it: "pose row 17", "POINTS", "quaternion"
  std::string value;    ///< the value found
  std::string problem;  ///< what is wrong with it, with the bound it broke
  std::string remedy;   ///< what the user can do
};

/// Base of all errors that outside input can cause. what() is one line:
/// "where: field = value: problem; remedy".
class MAPLESS_EXCEPTION Error : public std::runtime_error {
 public:
  explicit Error(ErrorDetail detail);
  [[nodiscard]] const ErrorDetail& detail() const { return detail_; }

 private:
  ErrorDetail detail_;
};

/// A file or scan that cannot be used: truncated, not finite, inconsistent, absent.
class MAPLESS_EXCEPTION InputError : public Error {
  using Error::Error;
};

/// A parameter or option that is unknown, of the wrong type, or out of bounds.
class MAPLESS_EXCEPTION ParameterError : public Error {
  using Error::Error;
};

/// A trajectory asked outside the time it covers.
class MAPLESS_EXCEPTION TrajectoryDomainError : public Error {
  using Error::Error;
};

/// A result that could not be written: no permission, disk full, already there.
class MAPLESS_EXCEPTION OutputError : public Error {
  using Error::Error;
};

}  // namespace mapless
