#pragma once

#include <stdexcept>
#include <string>
#include <system_error>

/// The library is compiled with hidden symbols. Exceptions need visible type information to be caught by type
/// outside a shared library.
#define MAPLESS_EXCEPTION __attribute__((visibility("default")))

namespace mapless::inline v1 {

/// What is wrong with one piece of outside input. Every member may be empty except `problem`.
struct ErrorDetail {
  std::string where;  ///< file (with line or scan where known), option, parameter or function
  std::string field;  ///< the field of the file, or the argument of the function: "pose row 17", "quaternion"
  std::string value;  ///< the value found
  std::string problem;  ///< what is wrong with the value, with the violated bound
  std::string remedy;   ///< what the user can do
};

/// Base of every error that outside input can cause. what() is one line without control characters:
/// "where: field = value: problem; remedy". Parts over 200 bytes (where 400, problem 600) are cut.
class MAPLESS_EXCEPTION Error : public std::runtime_error {
 public:
  explicit Error(ErrorDetail detail);
  [[nodiscard]] const ErrorDetail& detail() const { return detail_; }

 private:
  ErrorDetail detail_;
};

/// A file, scan or trajectory that cannot be used: truncated, not finite, inconsistent, absent.
class MAPLESS_EXCEPTION InputError : public Error {
  using Error::Error;
};

/// A file or folder that is there and that the system does not hand over: no permission, an error of the
/// disk.
class MAPLESS_EXCEPTION AccessError : public InputError {
  using InputError::InputError;
};

/// A parameter, argument or option that is unknown, of the wrong type, or out of bounds.
class MAPLESS_EXCEPTION ParameterError : public Error {
  using Error::Error;
};

/// A trajectory evaluated at an instant that it does not cover.
class MAPLESS_EXCEPTION TrajectoryDomainError : public Error {
  using Error::Error;
};

/// A result that could not be written: no permission, disk full, file exists.
class MAPLESS_EXCEPTION OutputError : public Error {
  using Error::Error;
};

/// A result that cannot be written now and perhaps later: the disk is full, another run uses the folder.
class MAPLESS_EXCEPTION TemporaryError : public OutputError {
  using OutputError::OutputError;
};

/// Throws InputError where `reason` says that there is no such file, else AccessError.
[[noreturn]] void throw_read_error(ErrorDetail detail, const std::error_code& reason);
/// Throws TemporaryError where `reason` is a full disk or quota, else OutputError.
[[noreturn]] void throw_write_error(ErrorDetail detail, const std::error_code& reason);

}  // namespace mapless
