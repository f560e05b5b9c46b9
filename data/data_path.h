#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace uiclink {

/// The folder of the data that come with the programs: parameter_sets/, geometry/, wagons/, freight/. The first of
///   1. $UICLINK_DATA, if it is set,
///   2. ../share/uiclink beside the folder of the running program (an installed tree, wherever it was moved to),
///   3. data/ of the source tree that the program was built from
/// that exists. @throws InputError if none does.
std::filesystem::path DataFolder();

/// The names that FindDataFile knows in a subfolder, sorted: "set1", "set2".
std::vector<std::string> DataNames(std::string_view subfolder);

/// What a user means by `text`: with a '/' or '.' in it a path, as it is; else the name of a file that comes with the
/// programs, DataFolder()/subfolder/text.toml.
/// @throws InputError if there is no such file; the message lists the names that there are.
std::filesystem::path FindDataFile(std::string_view subfolder, const std::string& text);

}  // namespace uiclink
