// MATLAB files of time histories, read back with matio.

#include "vehicle/mat_file.h"

#include <gtest/gtest.h>
#include <matio.h>

#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>

#include "tests/cli/temporary_folder.h"

namespace uiclink {
namespace {

struct Close {
  void operator()(mat_t* mat) const { Mat_Close(mat); }
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};

/// What a file holds: vectors by name, and texts.
struct Contents {
  std::map<std::string, std::vector<double>> columns;
  std::map<std::string, std::string> texts;
};

Contents ReadBack(const std::string& bytes) {
  const TemporaryFolder folder;
  folder.Write("a.mat", bytes);
  const std::unique_ptr<mat_t, Close> mat(Mat_Open((folder.path() / "a.mat").c_str(), MAT_ACC_RDONLY));
  if (!mat) throw std::runtime_error("matio cannot open it");
  Contents contents;
  while (const std::unique_ptr<matvar_t, Close> variable{Mat_VarReadNext(mat.get())}) {
    EXPECT_EQ(variable->rank, 2) << variable->name;
    if (variable->class_type == MAT_C_CHAR) {
      EXPECT_EQ(variable->dims[0], 1u) << variable->name;
      contents.texts[variable->name].assign(static_cast<const char*>(variable->data), variable->nbytes);
    } else {
      EXPECT_EQ(variable->class_type, MAT_C_DOUBLE) << variable->name;
      EXPECT_EQ(variable->dims[1], 1u) << "a column: " << variable->name;
      const auto* const values = static_cast<const double*>(variable->data);
      contents.columns[variable->name].assign(values, values + variable->dims[0]);
    }
  }
  return contents;
}

TEST(MatFile, ReadsBackBitByBit) {
  const std::vector<DataColumn> columns{{"time", "s", {0, 0.1, 0.2}},
                                        {"front_lateral", "mm", {1.0 / 3, -0.0, std::numeric_limits<double>::max()}},
                                        {"speed", "m/s", {24, 24, 24}}};
  const std::vector<MatText> texts{{"result", "{ \"schema\": \"wagon-simulate/1\" }"}};
  const Contents contents = ReadBack(FormatMatFile(columns, texts));
  ASSERT_EQ(contents.columns.size(), 3u);
  EXPECT_EQ(contents.columns.at("time_s"), columns[0].values);
  EXPECT_EQ(contents.columns.at("front_lateral_mm"), columns[1].values);
  EXPECT_TRUE(std::signbit(contents.columns.at("front_lateral_mm")[1]));
  EXPECT_EQ(contents.columns.at("speed_m_per_s"), columns[2].values);
  EXPECT_EQ(contents.texts.at("result"), texts[0].text);
}

TEST(MatFile, KeepsWhatIsNotFiniteAndLongHistories) {
  std::vector<double> values(100000, std::nan(""));
  for (std::size_t i = 1; i < values.size(); ++i) values[i] = std::sin(static_cast<double>(i));
  const Contents contents = ReadBack(FormatMatFile(std::vector<DataColumn>{{"y", "m", values}}));
  const std::vector<double>& y = contents.columns.at("y_m");
  ASSERT_EQ(y.size(), values.size());
  EXPECT_TRUE(std::isnan(y[0]));
  for (std::size_t i = 1; i < y.size(); ++i) ASSERT_EQ(y[i], values[i]) << i;
}

TEST(MatFile, TheSameColumnsGiveTheSameBytes) {
  const std::vector<DataColumn> columns{{"time", "s", {0, 1}}};
  const std::string bytes = FormatMatFile(columns);
  EXPECT_EQ(bytes, FormatMatFile(columns));
  EXPECT_TRUE(bytes.starts_with("MATLAB 5.0 MAT-file")) << bytes.substr(0, 40);
}

TEST(MatFile, RefusesTwoVariablesOfOneName) {
  const std::vector<DataColumn> twice{{"y", "m", {1}}, {"y_m", "", {2}}};
  EXPECT_THROW(FormatMatFile(twice), std::invalid_argument);
  const std::vector<MatText> text{{"y_m", "text"}};
  EXPECT_THROW(FormatMatFile(std::vector<DataColumn>{{"y", "m", {1}}}, text), std::invalid_argument);
}

}  // namespace
}  // namespace uiclink
