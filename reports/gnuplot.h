#pragma once

#include <string>

namespace uiclink {

/// What gnuplot writes to standard output for a script, in a process of its own: without the user's start-up files, and
/// without a file that has a name.
/// @throws FigureError (reports/figure.h) if gnuplot cannot be started, ends with an error, or says nothing.
std::string RunGnuplot(const std::string& script);

}  // namespace uiclink
