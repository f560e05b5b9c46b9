#pragma once

#include <stdexcept>
#include <string>

namespace uiclink {

/// A file of the user cannot be used. what() is "file:line: expected ..., found ...", or "file: ..." where no line
/// applies.
class InputError : public std::runtime_error {
 public:
  InputError(const std::string& file, int line, const std::string& message)
      : std::runtime_error(line > 0 ? file + ":" + std::to_string(line) + ": " + message : file + ": " + message),
        line_(line) {}

  int line() const { return line_; }  ///< 1-based; 0 where no line applies

 private:
  int line_;
};

}  // namespace uiclink
