#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "model/parameter_set.h"

namespace uiclink {

/// Reads a parameter set; the format with its units is in data/README.md.
///
/// Checks: load_N > 0, g > 0, k > 0, slider k > 0, T0 >= 0, std >= 0, at least one direction; a covariance whose order
/// names parameters of the set (k, k1, T01, ..., "effect.symbol"), square, symmetric, with correlations between -1
/// and 1, coverage > 0, spread >= 0 of parameters of the set. Effects are not looked up in the catalogue: the caller,
/// who knows it, does.
/// @throws InputError with all faults of the file, a line each.
ParameterSet ReadParameterSet(const std::filesystem::path& path);

/// The text part of ReadParameterSet: `text` is the whole file, `file` its name for messages.
ParameterSet ParseParameterSet(std::string_view text, const std::string& file);

/// The set as text, with units as comments. Reading it back gives every number bit by bit.
/// @throws std::invalid_argument if the set breaks a rule of ReadParameterSet.
std::string FormatParameterSet(const ParameterSet& set);

/// Writes FormatParameterSet(set), whole or not at all (data/file.h).
void WriteParameterSet(const ParameterSet& set, const std::filesystem::path& path);

}  // namespace uiclink
