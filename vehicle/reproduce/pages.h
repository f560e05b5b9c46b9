#pragma once

#include <map>
#include <string>

#include "vehicle/reproduce/reproduce.h"

namespace uiclink::reproduce {

/// Every page by its file name: "index.html", "10.1.html", ..., "10.5.html". Sections without an item that was asked
/// for are left out.
std::map<std::string, std::string> FormatPages(const Reproduction& reproduction);

/// Schema "wagon-reproduce/1" (vehicle/README.md): every row with theirs and ours.
std::string FormatReproductionJson(const Reproduction& reproduction);

/// Rows that are met, explained, unexplained by geometry, for a terminal; the unexplained ones by name.
std::string FormatReproduction(const Reproduction& reproduction);

}  // namespace uiclink::reproduce
