#include "data/data_path.h"

#include <algorithm>
#include <cstdlib>
#include <system_error>

#include "data/input_error.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;

bool IsFolder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

/// Empty where the system does not say it.
fs::path FolderOfProgram() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : program.parent_path();
}

}  // namespace

fs::path DataFolder() {
  if (const char* const asked = std::getenv("UICLINK_DATA"); asked != nullptr && *asked != '\0') {
    if (!IsFolder(asked))
      throw InputError("UICLINK_DATA", 0, "expected a folder, found \"" + std::string(asked) + "\"");
    return asked;
  }
  const fs::path installed = FolderOfProgram().parent_path() / "share/uiclink";
  for (const fs::path& folder : {installed, fs::path(UICLINK_SOURCE_DATA)}) {
    if (IsFolder(folder / "parameter_sets")) return folder;
  }
  throw InputError(installed.string(), 0, "expected the data of uiclink, found nothing (or set UICLINK_DATA)");
}

std::vector<std::string> DataNames(std::string_view subfolder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(DataFolder() / subfolder, ignored)) {
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  }
  std::ranges::sort(names);
  return names;
}

fs::path FindDataFile(std::string_view subfolder, const std::string& text) {
  const bool is_path = text.find_first_of("/.") != std::string::npos;
  const fs::path path = is_path ? fs::path(text) : DataFolder() / subfolder / (text + ".toml");
  std::error_code ignored;
  // A pipe is a file, too: `--set <(generate)`.
  if (!text.empty() && fs::exists(path, ignored) && !fs::is_directory(path, ignored)) return path;
  std::string names;
  for (const std::string& name : DataNames(subfolder)) names += (names.empty() ? "" : ", ") + name;
  const std::string expected =
      names.empty() ? "a file (the folder " + (DataFolder() / subfolder).string() + " of data files has none)"
                    : "a file or one of " + names;
  throw InputError(text.empty() ? "\"\"" : text, 0,
                   "expected " + expected + ", found " +
                       (IsFolder(path)  ? "a folder"
                        : names.empty() ? "none"
                                        : "neither"));
}

}  // namespace uiclink
