#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace uiclink {

/// SHA-256 of some bytes (FIPS 180-4) as 64 hexadecimal digits: what `sha256sum` prints.
std::string CalcSha256(std::string_view bytes);

/// SHA-256 of a file, so that a result can say what exactly it stands on.
/// @throws InputError where the file cannot be read.
std::string CalcFileSha256(const std::filesystem::path& path);

}  // namespace uiclink
