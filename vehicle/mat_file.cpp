#include "vehicle/mat_file.h"

#include <matio.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <set>
#include <stdexcept>

#include "data/file.h"

namespace uiclink {
namespace {

struct Close {
  void operator()(mat_t* mat) const { Mat_Close(mat); }
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};

/// matio writes to names only: an empty file of our own, gone at the end.
class TemporaryFile {
 public:
  TemporaryFile() : name_((std::filesystem::temp_directory_path() / "uiclink_XXXXXX").string()) {
    const int file = mkstemp(name_.data());
    if (file < 0) throw std::runtime_error("no temporary file " + name_);
    close(file);
  }
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(name_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& name() const { return name_; }

 private:
  std::string name_;
};

/// Mat_VarCreate only reads what it is given, but does not say so in its type.
void WriteVariable(mat_t* mat, const std::string& name, matio_classes kind, matio_types type,
                   std::array<std::size_t, 2> size, const void* values) {
  const std::unique_ptr<matvar_t, Close> variable(
      Mat_VarCreate(name.c_str(), kind, type, 2, size.data(), const_cast<void*>(values), MAT_F_DONT_COPY_DATA));
  if (!variable || Mat_VarWrite(mat, variable.get(), MAT_COMPRESSION_NONE) != 0) {
    throw std::runtime_error("FormatMatFile: variable " + name + " cannot be written (no space left?)");
  }
}

void RequireNew(const std::string& name, std::set<std::string>* names) {
  if (!names->insert(name).second) throw std::invalid_argument("FormatMatFile: two variables are called " + name);
}

}  // namespace

std::string FormatMatFile(std::span<const DataColumn> columns, std::span<const MatText> texts) {
  constexpr std::size_t kMostValues = std::size_t{1} << 28;
  const TemporaryFile file;
  std::set<std::string> names;
  {
    // The header's text would else have the date in it.
    const std::unique_ptr<mat_t, Close> mat(
        Mat_CreateVer(file.name().c_str(), "MATLAB 5.0 MAT-file, uiclink", MAT_FT_MAT5));
    if (!mat) throw std::runtime_error("FormatMatFile: no temporary file " + file.name());
    for (const DataColumn& column : columns) {
      const std::string name = ColumnWord(column);
      RequireNew(name, &names);
      if (column.values.size() >= kMostValues) throw std::invalid_argument("FormatMatFile: too many values of " + name);
      WriteVariable(mat.get(), name, MAT_C_DOUBLE, MAT_T_DOUBLE, {column.values.size(), 1}, column.values.data());
    }
    for (const MatText& text : texts) {
      RequireNew(text.name, &names);
      WriteVariable(mat.get(), text.name, MAT_C_CHAR, MAT_T_UTF8, {1, text.text.size()}, text.text.data());
    }
  }
  return ReadFileWhole(file.name());
}

}  // namespace uiclink
