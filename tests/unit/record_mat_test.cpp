#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <matio.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "tests/unit/record_samples.h"

namespace uiclink {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

using RecordMatTest = RecordFileTest;

using MatPtr = std::unique_ptr<mat_t, int (*)(mat_t*)>;

MatPtr CreateMat(const std::filesystem::path& path, mat_ft version) {
  return {Mat_CreateVer(path.c_str(), nullptr, version), &Mat_Close};
}

/// A matrix of the given columns; `turned`: rows instead.
matvar_t* MakeMatrix(const char* name, const std::vector<std::vector<double>>& columns, bool turned = false) {
  std::size_t dims[2] = {columns[0].size(), columns.size()};
  std::vector<double> data;
  for (const std::vector<double>& column : columns) data.insert(data.end(), column.begin(), column.end());
  if (turned) {
    data.clear();
    for (std::size_t i = 0; i < columns[0].size(); ++i) {
      for (const std::vector<double>& column : columns) data.push_back(column[i]);
    }
    std::swap(dims[0], dims[1]);
  }
  return Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims, data.data(), 0);
}

void Put(mat_t* mat, matvar_t* variable) {
  ASSERT_EQ(Mat_VarWrite(mat, variable, MAT_COMPRESSION_NONE), 0);
  Mat_VarFree(variable);
}

std::vector<double> Times(int first = 0, int last = kSamples) {
  std::vector<double> t;
  for (int i = first; i < last; ++i) t.push_back(Time(i));
  return t;
}

std::vector<double> Displacements(int first = 0, int last = kSamples) {
  std::vector<double> y;
  for (int i = first; i < last; ++i) y.push_back(DisplacementMm(i));
  return y;
}

TEST_F(RecordMatTest, ReadsAMatrixOfEveryMatlabLevel) {
  for (const mat_ft version : {MAT_FT_MAT4, MAT_FT_MAT5, MAT_FT_MAT73}) {
    for (const bool turned : {false, true}) {
      const auto path = Path("lateral_x.mat");
      {
        const MatPtr mat = CreateMat(path, version);
        Put(mat.get(), MakeMatrix("data", {Times(), Displacements()}, turned));
      }
      ExpectStandard(ReadRecord(path));
    }
  }
}

TEST_F(RecordMatTest, ReadsVectorsByName) {
  const auto path = Path("x.mat");
  {
    const MatPtr mat = CreateMat(path, MAT_FT_MAT5);
    Put(mat.get(), MakeMatrix("force", {Times()}));
    Put(mat.get(), MakeMatrix("y", {Displacements()}));
    Put(mat.get(), MakeMatrix("time", {Times()}, true));
    Put(mat.get(), MakeMatrix("mass_kg", {{400.0}}));
    std::size_t dims[2] = {1, 7};
    char word[] = "lateral";
    Put(mat.get(), Mat_VarCreate("direction", MAT_C_CHAR, MAT_T_UTF8, 2, dims, word, 0));
  }
  const Record record = ReadRecord(path);
  ExpectStandard(record);
  EXPECT_EQ(record.mass_kg, 400);
  EXPECT_EQ(record.direction, Direction::kLateral);
}

TEST_F(RecordMatTest, AsksWhenVariablesAreAmbiguous) {
  const auto path = Path("x.mat");
  {
    const MatPtr mat = CreateMat(path, MAT_FT_MAT5);
    Put(mat.get(), MakeMatrix("t", {Times()}));
    Put(mat.get(), MakeMatrix("left", {Displacements()}));
    Put(mat.get(), MakeMatrix("right", {Times()}));
  }
  EXPECT_THAT(FileFault(path), HasSubstr("x.mat: expected one displacement beside the time t, found 2 left, 3 right; "
                                         "choose with --column N"));
  ExpectStandard(ReadRecord(path, {.column = 2}));
}

TEST_F(RecordMatTest, ReadsOneVectorWithARate) {
  const auto path = Path("x.mat");
  {
    const MatPtr mat = CreateMat(path, MAT_FT_MAT5);
    Put(mat.get(), MakeMatrix("angle", {Displacements()}, true));
  }
  EXPECT_THAT(FileFault(path), HasSubstr("--rate HZ"));
  ExpectStandard(ReadRecord(path, {.rate_hz = 200}));
  {
    const MatPtr mat = CreateMat(path, MAT_FT_MAT5);
    Put(mat.get(), MakeMatrix("angle", {Displacements()}, true));
    Put(mat.get(), MakeMatrix("dt", {{0.005}}));
  }
  ExpectStandard(ReadRecord(path));
}

TEST_F(RecordMatTest, JoinsRunsThatFollowEachOther) {
  const auto write = [&](int second_start) {
    const MatPtr mat = CreateMat(Path("x.mat"), MAT_FT_MAT5);
    Put(mat.get(), MakeMatrix("Time_b", {Times(second_start)}));
    Put(mat.get(), MakeMatrix("Time_a", {Times(0, 20)}));
    Put(mat.get(), MakeMatrix("Y_b", {Displacements(second_start)}));
    Put(mat.get(), MakeMatrix("Y_a", {Displacements(0, 20)}));
  };
  write(20);  // both runs as long: the suffixes pair them
  const Record record = ReadRecord(Path("x.mat"));
  ExpectStandard(record);
  EXPECT_THAT(record.notices, testing::Contains(HasSubstr("2 runs that follow each other are joined")));
  write(22);
  EXPECT_THAT(FileFault(Path("x.mat")), HasSubstr("found several that do not follow each other"));
}

TEST_F(RecordMatTest, ReadsCellsOfPiecesAndStructs) {
  const auto path = Path("x.mat");
  {
    const MatPtr mat = CreateMat(path, MAT_FT_MAT5);
    std::size_t dims[2] = {2, 1};
    matvar_t* times[] = {MakeMatrix(nullptr, {Times(0, 15)}), MakeMatrix(nullptr, {Times(15)})};
    matvar_t* values[] = {MakeMatrix(nullptr, {Displacements(0, 15), Times(0, 15)}, true),
                          MakeMatrix(nullptr, {Displacements(15), Times(15)}, true)};
    Put(mat.get(), Mat_VarCreate("Time", MAT_C_CELL, MAT_T_CELL, 2, dims, times, 0));
    Put(mat.get(), Mat_VarCreate("Y", MAT_C_CELL, MAT_T_CELL, 2, dims, values, 0));
  }
  ExpectStandard(ReadRecord(path));
  {
    const MatPtr mat = CreateMat(path, MAT_FT_MAT5);
    std::size_t dims[2] = {1, 1};
    const char* fields[] = {"Time", "Data"};
    matvar_t* run = Mat_VarCreateStruct("run", 2, dims, fields, 2);
    Mat_VarSetStructFieldByName(run, "Time", 0, MakeMatrix("Time", {Times()}));
    Mat_VarSetStructFieldByName(run, "Data", 0, MakeMatrix("Data", {Displacements()}));
    Put(mat.get(), run);
  }
  ExpectStandard(ReadRecord(path));
}

TEST_F(RecordMatTest, NamesWhatIsWrongWithAMatlabFile) {
  const auto path = Path("x.mat");
  {
    const MatPtr mat = CreateMat(path, MAT_FT_MAT5);
    std::vector<double> y = Displacements();
    y[4] = std::nan("");
    Put(mat.get(), MakeMatrix("t", {Times()}));
    Put(mat.get(), MakeMatrix("y", {y}));
  }
  EXPECT_THAT(FileFault(path), HasSubstr("x.mat: expected numbers, found nan at sample 5 of 40 (1 in all)"));
  {
    const MatPtr mat = CreateMat(path, MAT_FT_MAT5);
    Put(mat.get(), MakeMatrix("left", {Displacements()}));
    Put(mat.get(), MakeMatrix("right", {Displacements()}));
  }
  EXPECT_THAT(FileFault(path), HasSubstr("found left (40 x 1), right (40 x 1)"));
}

TEST_F(RecordMatTest, ADamagedMatlabFileIsAFaultNotACrash) {
  for (const mat_ft version : {MAT_FT_MAT5, MAT_FT_MAT73}) {
    const auto path = Path("x.mat");
    {
      const MatPtr mat = CreateMat(path, version);
      Put(mat.get(), MakeMatrix("data", {Times(), Displacements()}));
    }
    const auto size = std::filesystem::file_size(path);
    for (const auto kept : {size / 8, size / 2, size - 9}) {
      std::filesystem::resize_file(path, kept);
      testing::internal::CaptureStderr();
      const std::string fault = FileFault(path);
      EXPECT_THAT(testing::internal::GetCapturedStderr(), IsEmpty()) << "libraries must not talk to users";
      EXPECT_THAT(fault, Not(testing::StrEq("no fault"))) << kept << " of " << size;
    }
  }
}

}  // namespace
}  // namespace uiclink
