#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace uiclink {

/// The bytes of a file, unchanged.
/// @throws InputError "file: expected a readable file, found ..." (nothing, a directory, no permission, ...).
std::string ReadFileWhole(const std::filesystem::path& path);

/// Writes `content` whole or not at all: a reader sees the old file or the new one, and a run that is interrupted or a
/// disk that is full leaves the old one. Creates the folder. What is no regular file (a pipe, /dev/stdout) is written
/// to directly; a symbolic link stays one, and its target is replaced.
/// @throws InputError "file: expected a file that can be written, found ...".
void WriteFileWhole(const std::filesystem::path& path, std::string_view content);

}  // namespace uiclink
