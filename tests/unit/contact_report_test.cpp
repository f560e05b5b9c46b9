#include "vehicle/contact_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "vehicle/contact/calc_contact_table.h"

namespace uiclink {
namespace {

using testing::HasSubstr;
using testing::Not;

class ContactReport : public testing::Test {
 protected:
  void Make(ContactModel model) {
    TrackGeometry geometry =
        ReadTrackGeometry(std::filesystem::path(UICLINK_SOURCE_DIR) / "data/geometry/nominal-1435-rigid.toml");
    geometry.contact = model;
    geometry.rows = 361;
    inputs_.table = CalcContactTable(geometry, inputs_.contact_notes.emplace());
    inputs_.geometry = geometry;
    analysis_ = AnalyseContact(inputs_);
  }

  WagonInputs inputs_;
  ContactAnalysis analysis_;
};

TEST_F(ContactReport, SaysWhatTheGeometryDoes) {
  Make(ContactModel::kRigid);
  const std::string text = FormatContact(inputs_, analysis_);
  EXPECT_THAT(text, HasSubstr("nominal-1435-rigid: S1002 on UIC60 1:40, gauge 1435 mm at 14 mm below the top"));
  EXPECT_THAT(text, HasSubstr("Jumps of the contact"));
  EXPECT_THAT(text, HasSubstr("mm, flange root: at "));
  EXPECT_THAT(text, Not(HasSubstr("further out")));
  const auto three = std::ranges::find(analysis_.conicity, 3e-3, &ConicityPoint::amplitude);
  ASSERT_NE(three, analysis_.conicity.end());
  EXPECT_NEAR(three->equivalent, 0.18, 0.005);  // the usual figure of this pair
  EXPECT_NEAR(three->en15302, 0.18, 0.005);
}

TEST_F(ContactReport, JsonHasItsSchema) {
  Make(ContactModel::kRigid);
  const nlohmann::json json = nlohmann::json::parse(FormatContactJson(inputs_, analysis_));
  EXPECT_EQ(json["schema"], "wagon-contact/1");
  EXPECT_EQ(json["table"]["contact"], "rigid");
  EXPECT_EQ(json["table"]["rows"], inputs_.table.rows.size());
  EXPECT_EQ(json["jumps"].size(), inputs_.contact_notes->jumps.size());
  const auto& ranges = json["two_point_contact"];
  EXPECT_TRUE(std::ranges::any_of(ranges, [](const auto& range) { return range["where"] == "flange root"; }));
  for (const auto& range : ranges) EXPECT_LE(range["y_from"], range["y_to"]);
  for (const auto& row : json["rows"]) EXPECT_EQ(row.size(), 15);
}

TEST_F(ContactReport, ElasticContactHasNoJumps) {
  Make(ContactModel::kElastic);
  EXPECT_THAT(FormatContact(inputs_, analysis_), HasSubstr("Elastic contact: the table has no jumps."));
  EXPECT_TRUE(nlohmann::json::parse(FormatContactJson(inputs_, analysis_))["jumps"].empty());
}

TEST_F(ContactReport, ATableFromAFileHasWhatATableCanTell) {
  Make(ContactModel::kRigid);
  inputs_.geometry.reset();
  inputs_.contact_notes.reset();
  analysis_ = AnalyseContact(inputs_);
  const std::string text = FormatContact(inputs_, analysis_);
  EXPECT_THAT(text, HasSubstr("nominal-1435-rigid: a table of "));
  EXPECT_THAT(text, Not(HasSubstr("Two points")));
  const nlohmann::json json = nlohmann::json::parse(FormatContactJson(inputs_, analysis_));
  EXPECT_TRUE(json["jumps"].is_null());
  EXPECT_TRUE(json["conicity"][0]["en15302"].is_null());
  EXPECT_FALSE(json["conicity"][0]["equivalent"].is_null());
  EXPECT_EQ(ConicityFigure(inputs_, analysis_).panels[1].series.size(), 1);
}

TEST_F(ContactReport, FiguresShowTheQuantitiesOfAppendixHAndBreakAtJumps) {
  Make(ContactModel::kRigid);
  const Figure figure = ContactTableFigure(inputs_);
  EXPECT_EQ(figure.panels.size(), 12);  // eleven of the appendix, and the lift
  for (const FigurePanel& panel : figure.panels) {
    for (const FigureSeries& series : panel.series) {
      const auto gaps = std::ranges::count_if(series.y, [](double y) { return std::isnan(y); });
      EXPECT_EQ(static_cast<std::size_t>(gaps), inputs_.contact_notes->jumps.size()) << panel.title;
    }
  }
  EXPECT_EQ(ConicityFigure(inputs_, analysis_).panels.size(), 2);
}

}  // namespace
}  // namespace uiclink
