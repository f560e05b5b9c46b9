#pragma once

#include <string>

namespace uiclink {

/// An SVG document as an element of a page: without its prologue, ids with a prefix, named by `description`, and, if it
/// is gnuplot's, without what that repeats. Empty if `svg` is none.
std::string InlineSvg(const std::string& svg, const std::string& prefix, const std::string& description);

}  // namespace uiclink
