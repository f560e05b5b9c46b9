// The report of an identification: what its sections say is what the result holds.

#include "identify/page/report_page.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "data/file.h"
#include "identify/profiles.h"
#include "identify/report_diagnosis.h"
#include "identify/report_wagon.h"
#include "measurements/rig/rig.h"
#include "reports/pictures.h"
#include "tests/cli/temporary_folder.h"
#include "tests/support/rig_records.h"

namespace uiclink {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;

std::vector<Record> MakeNamedRecords(const rig::Settings& settings, int count, Direction direction) {
  std::vector<Record> records = MakeRecords(settings, count, direction);
  for (std::size_t i = 0; i < records.size(); ++i)
    records[i].file = fmt::format("{}_{:02}.txt", Name(direction), i + 1);
  return records;
}

Identification IdentifyRecords(std::vector<Record> records, Direction direction) {
  IdentifyOptions options;
  options.sliders = 1;
  options.starts.count = 0;
  options.threads = 1;
  return Identify(direction, std::move(records), options);
}

/// A run and the page on it.
struct Report {
  RunResult run;
  std::vector<ValidationSet> sets;
  std::vector<ReadingResiduals> residuals;
  Provenance provenance;
  ReportPage page;

  ReportInput Input() const {
    return {
        .run = &run, .sets = sets, .residuals = residuals, .provenance = &provenance, .threads = 1, .no_pictures = {}};
  }

  void Compose() {
    sets = {MakeValidationSet(run, /*with_causes=*/true, "out/parameters.toml")};
    residuals = CalcReadingResiduals(run);
    page = ComposeReportPage(Input());
  }

  Json Result() const { return Json::parse(FormatJson(run)); }

  /// The HTML of a section, up to the next one.
  std::string Section(const std::string& id) const {
    const std::size_t from = page.html.find(fmt::format("<h2 id=\"{}\"", id));
    if (from == std::string::npos) return {};
    return page.html.substr(from, page.html.find("<h2 ", from + 1) - from);
  }
  /// What stands before the first section.
  std::string Answer() const {
    const std::size_t from = page.html.find("<h1");
    return page.html.substr(from, page.html.find("<h2 ", from) - from);
  }
  const Figure* Find(const std::string& name) const {
    const auto found = std::ranges::find(page.figures, name, &PageFigure::name);
    return found == page.figures.end() ? nullptr : &found->figure;
  }
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const PageFigure& figure : page.figures) names.push_back(figure.name);
    return names;
  }
};

const FigureSeries* FindSeries(const FigurePanel& panel, const std::string& name) {
  const auto found = std::ranges::find(panel.series, name, &FigureSeries::name);
  return found == panel.series.end() ? nullptr : &*found;
}

std::size_t Count(const std::string& word, const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
  return count;
}

double CalcRms(const std::vector<double>& values) {
  double squares = 0;
  for (const double x : values) squares += x * x;
  return std::sqrt(squares / static_cast<double>(values.size()));
}

/// A row of the wagon with numbers of the test's own.
ValidationRow MakeRow() {
  ValidationRow row;
  row.set.set.name = "identified";
  row.critical_speed.emplace();
  row.critical_speed->value = 6.156;
  row.critical_speed->low = 6.134;
  row.critical_speed->high = 6.177;
  row.hunting = HuntingRun{};
  row.hunting->wheelset_amplitude = {0.36e-3, 0.33e-3};
  row.hunting->impacts = {3, 0};
  row.hunting->peak_impact = 2500;
  row.notices = {"the longitudinal direction was not measured: it comes from set 1"};
  return row;
}

/// Three records with damping that the plain model lacks.
const Report& Explained() {
  static const Report report = [] {
    rig::Settings settings = PlainLateral(32);
    settings.link.effects.viscous_c = 0.006;
    Report made;
    made.run.directions.push_back(
        IdentifyRecords(MakeNamedRecords(settings, 3, Direction::kLateral), Direction::kLateral));
    made.run.diagnoses.push_back(Diagnose(made.run.directions[0], {.threads = 1, .progress = {}}));
    made.run.rejected.push_back({"torn.txt", "torn.txt:3: expected a number, found \"<b>\""});
    made.run.wagon.emplace();
    made.run.wagon->wagon = "Hbbills 311";
    made.run.wagon->cargo = "empty";
    made.run.wagon->geometry = "nominal-1435";
    made.run.wagon->rows = {MakeRow()};
    made.provenance = {.command = "identify 'a b.txt'",
                       .written = "2003-03-14 15:09 UTC",
                       .inputs = {{"lateral_01.txt", "abc123"}, {"torn.txt", ""}},
                       .options = {{"--seed", "1"}, {"--mass", ""}}};
    made.Compose();
    return made;
  }();
  return report;
}

TEST(ReportPage, AnswersTheFourQuestionsOnTheFirstScreen) {
  const Report& report = Explained();
  const Json json = report.Result();
  ASSERT_EQ(json["diagnosis"]["verdict"], "explained");
  const Json k = json["extended_fit"]["parameters"]["k"], c = json["diagnosis"]["causes"][0]["parameters"]["c"];
  const auto round = [](const Json& e, const char* key) { return Round(e[key], e["std"]); };
  EXPECT_THAT(
      report.Answer(),
      AllOf(HasSubstr(fmt::format("{} 1/m (95 %: {} to {})", round(k, "value"), round(k, "low"), round(k, "high"))),
            HasSubstr("What is the stiffness k?"), HasSubstr("Is the plain dry-friction model adequate?"),
            HasSubstr("What does it lack?"), HasSubstr("How fast may the wagon run?")));
  EXPECT_THAT(report.Answer(), HasSubstr(fmt::format("c = {} s/m", round(c, "value"))));
  EXPECT_THAT(report.Answer(), HasSubstr("viscous damping beside the dry friction"));
  EXPECT_THAT(report.Answer(), HasSubstr("stable up to 6.16 m/s (22.2 km/h)"));
  EXPECT_THAT(report.Answer(), HasSubstr("6.13 to 6.18 m/s"));
  EXPECT_THAT(report.Answer(), HasSubstr("with 3 impacts on the guidance of up to 2.5 kN"));
  EXPECT_THAT(report.Answer(), HasSubstr("the longitudinal direction was not measured"));
  // 378.2 kg times 9.82 m/s^2.
  EXPECT_THAT(report.Answer(), HasSubstr("3714 N"));
  const double kilonewton = 1e-3 * 378.2 * 9.82;
  EXPECT_THAT(report.Answer(),
              HasSubstr(Round(kilonewton * k["value"].get<double>(), kilonewton * k["std"].get<double>()) + " kN/m"));
}

TEST(ReportPage, ListsEveryRecordWithItsUse) {
  const std::string section = Explained().Section("records");
  for (const char* word : {"lateral_01.txt", "lateral_02.txt", "lateral_03.txt", "used", "torn.txt", "not read",
                           "expected a number, found &quot;&lt;b&gt;&quot;"})
    EXPECT_THAT(section, HasSubstr(word));
  const Json record = Explained().Result()["records"][0];
  EXPECT_THAT(section, HasSubstr(fmt::format("{:.4f}", record["noise_mm"].get<double>())));
}

TEST(ReportPage, DrawsPhasesAndFrequenciesWhereTheyWereRead) {
  const Report& report = Explained();
  const Figure* const phases = report.Find("lateral_phases");
  ASSERT_NE(phases, nullptr);
  const auto& records = report.run.directions[0].records;
  const auto typical =
      std::ranges::find_if(records, [&](const RecordResult& r) { return r.record.file == phases->title + ".txt"; });
  ASSERT_NE(typical, records.end());
  const std::vector<FigureGuide>& guides = phases->panels[0].vertical_guides;
  ASSERT_EQ(guides.size(), 3u);
  EXPECT_EQ(guides[0].value, typical->phases.release_s);
  EXPECT_EQ(guides[1].value, typical->phases.extrema[0].t);
  EXPECT_EQ(guides[2].value, typical->phases.extrema[typical->phases.rolling_start].t);

  const Figure* const frequencies = report.Find("lateral_frequencies");
  ASSERT_NE(frequencies, nullptr);
  // The published sine ends at the extremum; it goes through the cut-off point where the method says.
  const SineFit& sine = *typical->sine;
  const FigureSeries* const arc = FindSeries(frequencies->panels[0], "sine about zero");
  ASSERT_NE(arc, nullptr);
  EXPECT_NEAR(arc->x.back(), sine.arcs[0].extremum_t, 1e-12);
  EXPECT_NEAR(std::abs(arc->y.back() - 1e3 * sine.zero), 1e3 * sine.arcs[0].extremum, 1e-9);
  const FigureSeries* const crossings = FindSeries(frequencies->panels[1], "first and last crossing");
  ASSERT_NE(crossings, nullptr);
  EXPECT_NEAR(2 * M_PI * sine.rolling_periods / (crossings->x[1] - crossings->x[0]), sine.omega_rolling,
              1e-12 * sine.omega_rolling);
  EXPECT_EQ(report.Find("lateral_records")->panels.size(), 3u);
}

TEST(ReportPage, DrawsTheStiffnessOfEveryRecord) {
  const Report& report = Explained();
  const Figure& figure = *report.Find("lateral_stiffness");
  ASSERT_EQ(figure.panels.size(), 3u);
  const Json records = report.Result()["records"];
  const FigureSeries* const published = FindSeries(figure.panels[0], "frequency method, as published");
  const FigureSeries* const plain = FindSeries(figure.panels[0], "plain model, its own fit with 95 %");
  ASSERT_TRUE(published != nullptr && plain != nullptr);
  for (std::size_t r = 0; r < 3; ++r) {
    EXPECT_DOUBLE_EQ(published->y[r], records[r]["sine_fit"]["k"].get<double>());
    EXPECT_DOUBLE_EQ(plain->y[r], records[r]["own_fit"]["k"]["value"].get<double>());
  }
}

TEST(ReportPage, DrawsWhatTheModelsLeave) {
  const Report& report = Explained();
  const Figure& figure = *report.Find("lateral_models");
  ASSERT_EQ(figure.panels.size(), 2u);
  const std::string file = figure.title.substr(0, figure.title.find(':')) + ".txt";
  for (const Json& record : report.Result()["records"]) {
    if (record["file"] != file) continue;
    // The sum of squares is that of the fit, in another order.
    EXPECT_NEAR(CalcRms(FindSeries(figure.panels[1], "plain model")->y), record["rms_mm"].get<double>(), 1e-9);
  }
  const double extended = CalcRms(FindSeries(figure.panels[1], "extended model")->y);
  EXPECT_LT(extended, 1.1 * 1e3 * report.run.directions[0].noise);
  const FigurePanel& readings = figure.panels[0];
  const std::vector<double>&measured = FindSeries(readings, "measured")->y,
        &modelled = FindSeries(readings, "plain model")->y, &left = FindSeries(figure.panels[1], "plain model")->y;
  ASSERT_EQ(measured.size(), left.size());
  for (std::size_t i = 0; i < left.size(); i += 97) EXPECT_NEAR(measured[i] - modelled[i], left[i], 1e-12);
  EXPECT_EQ(report.Find("lateral_residuals")->panels.size(), 3u);
}

TEST(ReportPage, DrawsEnergyLoopsAndResidualsOfBothModels) {
  const Report& report = Explained();
  const Figure& energy = *report.Find("lateral_energy");
  ASSERT_EQ(energy.panels.size(), 3u);
  for (const FigurePanel& panel : energy.panels) {
    EXPECT_NE(FindSeries(panel, "plain model"), nullptr);
    EXPECT_NE(FindSeries(panel, "extended model"), nullptr);
    EXPECT_FALSE(panel.x.unit.empty());
    EXPECT_FALSE(panel.y.unit.empty());
  }
  const Figure& loops = *report.Find("lateral_loops");
  const FigureSeries& measured = *FindSeries(loops.panels[0], "measured");
  const FigureSeries& extended = *FindSeries(loops.panels[0], "extended model");
  ASSERT_EQ(measured.y.size(), extended.y.size());
  // Force of the largest swing, some 0.08 of the load; the right model has the same loop within the noise of windows
  // of a tenth of a second (second derivative of 0.013 mm: below 1e-3).
  double largest = 0, apart = 0;
  for (std::size_t i = 0; i < measured.y.size(); ++i) {
    largest = std::max(largest, std::abs(measured.y[i]));
    apart = std::max(apart, std::abs(measured.y[i] - extended.y[i]));
  }
  EXPECT_NEAR(largest, 0.08, 0.03);
  EXPECT_LT(apart, 4e-3);
  EXPECT_GE(report.Find("lateral_diagnostics")->panels.size(), 5u);
  EXPECT_THAT(report.Section("residuals"), HasSubstr("What the plain model gets wrong"));
}

TEST(ReportPage, WordsCausesWithTheirRivals) {
  const Report& report = Explained();
  const std::string section = report.Section("causes");
  EXPECT_THAT(section, HasSubstr("No other effect does as well in its place."));
  EXPECT_THAT(section, HasSubstr("one that the catalogue does not have cannot be excluded"));
  for (const Candidate& candidate : report.run.diagnoses[0].candidates)
    EXPECT_THAT(section, HasSubstr(std::string(candidate.effect->id)));

  Report confused = report;
  confused.run.diagnoses[0].causes[0].rivals = {FindEffect("quadratic_drag")};
  confused.Compose();
  for (const std::string& where : {confused.Answer(), confused.Section("causes")})
    EXPECT_THAT(where, HasSubstr("These records cannot tell it from quadratic_drag"));
  EXPECT_THAT(confused.Section("causes"), HasSubstr("the records do not decide between them"));
}

TEST(ReportPage, GivesParametersCorrelationsAndProfiles) {
  const Report& report = Explained();
  const std::string section = report.Section("parameters");
  const Json parameters = report.Result()["extended_fit"]["parameters"];
  for (const char* symbol : {"k", "k1", "T01"}) {
    const Json& e = parameters[symbol];
    EXPECT_THAT(section, HasSubstr(">" + Round(e["value"], e["std"]) + "<")) << symbol;
  }
  const Covariance& covariance = *report.sets[0].set.lateral->covariance;
  const double correlation = covariance.matrix[0][1] / std::sqrt(covariance.matrix[0][0] * covariance.matrix[1][1]);
  EXPECT_THAT(section, HasSubstr(fmt::format(">{:+.2f}<", correlation)));
  const Figure* const profiles = report.Find("lateral_profiles");
  ASSERT_NE(profiles, nullptr);
  EXPECT_EQ(profiles->panels.size(), 4u) << "k, k1, T01 and c";
  EXPECT_THAT(report.Section("identifiability"), HasSubstr("With it these records determine"));
}

TEST(ReportPage, SaysWhatItTakesToRepeatTheRun) {
  const std::string section = Explained().Section("repeat");
  for (const char* word : {"identify &#39;a b.txt&#39;", "2003-03-14 15:09 UTC", UICLINK_VERSION, "abc123",
                           "could not be read", "--seed", "out/parameters.toml"})
    EXPECT_THAT(section, HasSubstr(word));
  EXPECT_THAT(section, HasSubstr(Explained().sets[0].sha256));
}

TEST(ReportPage, SaysWhenPicturesAreMissing) {
  ReportInput input = Explained().Input();
  input.no_pictures = "gnuplot is not installed";
  const std::string html = ComposeReportPage(input).html;
  EXPECT_THAT(html, HasSubstr("No SVG and PNG files beside this page: gnuplot is not installed"));
  EXPECT_THAT(html, AllOf(HasSubstr("figures/lateral_phases.csv"), Not(HasSubstr("figures/lateral_phases.svg"))));
}

TEST(ReportPage, IsWrittenWithItsFigures) {
  const TemporaryFolder folder;
  folder.Write("figures/lateral_phases.svg", "of an earlier run");
  const std::string missing = WriteReportPage(Explained().Input(), folder.path());
  EXPECT_EQ(ReadFileWhole(folder.path() / "report.html").find("<!DOCTYPE html>"), 0u);
  for (const std::string& name : Explained().Names()) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "figures" / (name + ".csv"))) << name;
    for (const char* ending : {".svg", ".png"})
      EXPECT_EQ(std::filesystem::exists(folder.path() / "figures" / (name + ending)), missing.empty())
          << name << ending;
  }
  if (!missing.empty()) return;
  EXPECT_THAT(ReadFileWhole(folder.path() / "figures/lateral_phases.svg"), HasSubstr("<svg"));
}

TEST(ReportPage, ShowsTheMissingForceWhereNothingKnownExplainsTheRecords) {
  rig::Settings settings = PlainLateral(51);
  settings.link.effects.bump_height = 0.004;
  Report report;
  report.run.directions.push_back(
      IdentifyRecords(MakeNamedRecords(settings, 3, Direction::kLateral), Direction::kLateral));
  report.run.diagnoses.push_back(Diagnose(report.run.directions[0], {.threads = 1, .progress = {}}));
  report.Compose();
  const Diagnosis& diagnosis = report.run.diagnoses[0];
  ASSERT_EQ(diagnosis.verdict, Verdict::kUnexplained);
  ASSERT_TRUE(diagnosis.missing_force.has_value());
  EXPECT_THAT(report.Answer(), AllOf(HasSubstr("unexplained"), HasSubstr(diagnosis.missing_force->words),
                                     HasSubstr("something that the catalogue of effects does not have")));
  EXPECT_THAT(report.Answer(), HasSubstr("not asked (--no-wagon)"));
  EXPECT_THAT(report.Answer(), HasSubstr("under 3714 N; not to be trusted as it stands"));
  const Figure* const figure = report.Find("lateral_missing_force");
  ASSERT_NE(figure, nullptr);
  ASSERT_EQ(figure->panels.size(), 4u);
  std::size_t cells = 0;
  for (const FigureSeries& series : figure->panels[0].series) cells += series.x.size();
  EXPECT_EQ(cells, diagnosis.missing_force->map.size()) << "every cell of the map is in one class";
  EXPECT_EQ(figure->panels[1].series.back().y.size(), diagnosis.missing_force->over_y.size());
}

TEST(ReportPage, ManagesOneRecordWithoutDiagnosisAndWagonWhateverItsName) {
  std::vector<Record> records = MakeRecords(PlainLateral(7), 1, Direction::kLateral);
  records[0].file = "x/<script>alert(1)</script>.txt";
  Report report;
  report.run.directions.push_back(IdentifyRecords(std::move(records), Direction::kLateral));
  report.provenance.inputs = {{"x/<script>alert(1)</script>.txt", ""}};
  report.Compose();
  EXPECT_THAT(report.page.html, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(report.page.html, HasSubstr("&lt;script&gt;alert(1)"));
  EXPECT_THAT(report.Answer(), AllOf(HasSubstr("1 lateral ring-down of"), HasSubstr("--no-diagnosis"),
                                     HasSubstr("--no-wagon"), HasSubstr("nothing about scatter")));
  EXPECT_EQ(report.Find("lateral_records"), nullptr) << "one record is drawn once";
  EXPECT_EQ(report.Find("lateral_energy"), nullptr);
  EXPECT_NE(report.Find("lateral_loops"), nullptr);
  EXPECT_THAT(report.Section("wagon"), HasSubstr("No run on the wagon was asked for"));
}

TEST(ReportPage, LeavesAnUnusableRecordOutAndShowsIt) {
  std::vector<Record> records = MakeNamedRecords(PlainLateral(8), 3, Direction::kLateral);
  std::ranges::fill(records[1].y, 1e-3);  // a sensor that was not plugged in
  Report report;
  report.run.directions.push_back(IdentifyRecords(std::move(records), Direction::kLateral));
  report.Compose();
  const RecordResult& left_out = report.run.directions[0].records[1];
  ASSERT_FALSE(left_out.used);
  EXPECT_THAT(report.Section("records"), HasSubstr("left out"));
  EXPECT_THAT(report.Answer(), HasSubstr("1 of 3 could not be used"));
  const Figure& figure = *report.Find("lateral_records");
  ASSERT_EQ(figure.panels.size(), 3u);
  EXPECT_EQ(figure.panels[1].title, "lateral_02.txt (left out)");
}

// 20 records of two directions: how large and how quick the page is.
TEST(ReportPage, OfTwentyRecordsIsSmallAndQuick) {
  Report report;
  for (const Direction direction : {Direction::kLateral, Direction::kLongitudinal}) {
    rig::Settings settings = PlainLateral(direction == Direction::kLateral ? 91 : 92);
    settings.scatter = kReseating;
    report.run.directions.push_back(IdentifyRecords(MakeNamedRecords(settings, 10, direction), direction));
  }
  const std::clock_t before = std::clock();
  report.Compose();
  const double seconds = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
  std::printf("20 records: %.2f MB, %.3f s of processor time without pictures\n",
              1e-6 * static_cast<double>(report.page.html.size()), seconds);
  EXPECT_LT(report.page.html.size(), 5'000'000u);
  EXPECT_GT(report.page.html.size(), 100'000u);
  // Half a second for ten is what is promised, pictures included; three times that is for slow machines and sanitizers.
  EXPECT_LT(seconds, 3.0);
  EXPECT_THAT(report.Answer(), AllOf(HasSubstr("10 lateral ring-downs"), HasSubstr("10 longitudinal ring-downs")));
  for (const char* direction : {"lateral", "longitudinal"}) {
    const Figure* const figure = report.Find(std::string(direction) + "_records");
    ASSERT_NE(figure, nullptr);
    EXPECT_EQ(figure->panels.size(), 10u);
  }
}

TEST(RenderPictures, DrawsWhatSvgAndPngByThemselvesDraw) {
  std::vector<Figure> figures;
  for (const char* name : {"lateral_profiles", "lateral_stiffness"}) figures.push_back(*Explained().Find(name));
  try {
    const std::vector<Pictures> pictures = RenderPictures(figures);
    ASSERT_EQ(pictures.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      const std::string alone = RenderSvg(figures[i]);
      for (const char* element : {"<path ", "<use ", "<text>", "<title>", "</svg>"})
        EXPECT_EQ(Count(element, pictures[i].svg), Count(element, alone)) << element;
      EXPECT_EQ(pictures[i].svg.find("<?xml"), 0u);
      EXPECT_TRUE(pictures[i].png == RenderPng(figures[i])) << i;
    }
  } catch (const FigureError& error) {
    GTEST_SKIP() << error.what();
  }
}

// ---------------------------------------------------------------- profiles

TEST(CalcProfiles, EndWhereTheBoundsOfTheFitEnd) {
  const Identification id =
      IdentifyRecords(MakeNamedRecords(PlainLateral(3), 3, Direction::kLateral), Direction::kLateral);
  ASSERT_TRUE(id.shared);
  const std::vector<LikelihoodProfile> profiles = CalcProfiles(id, DescribePlain(id), {}, 1);
  ASSERT_EQ(profiles.size(), 3u);
  for (std::size_t q = 0; q < 3; ++q) {
    const LikelihoodProfile& profile = profiles[q];
    EXPECT_EQ(profile.symbol, QuantityName(1, static_cast<int>(q)));
    EXPECT_EQ(profile.record, -1);
    EXPECT_TRUE(std::ranges::is_sorted(profile.value));
    EXPECT_TRUE(std::ranges::is_sorted(profile.root));
    const Estimate& e = id.quantities[q];
    const std::optional<double> low = profile.Find(-std::sqrt(kProfileRise)),
                                high = profile.Find(std::sqrt(kProfileRise));
    ASSERT_TRUE(low && high) << profile.symbol;
    // Bounds of the identification come from profiles of its own code, refitted at other points, to a hundredth of the
    // half width; the variance factors of the two differ by as much as the records' mean squares do, some per cent.
    const double half = 0.5 * (e.high - e.low);
    EXPECT_NEAR(*low, e.low, 0.06 * half) << profile.symbol;
    EXPECT_NEAR(*high, e.high, 0.06 * half) << profile.symbol;
  }
}

TEST(CalcProfiles, AreOfEachRecordWhereTheLinksDiffer) {
  rig::Settings settings = PlainLateral(5);
  settings.scatter = kReseating;
  const Identification id = IdentifyRecords(MakeNamedRecords(settings, 3, Direction::kLateral), Direction::kLateral);
  ASSERT_FALSE(id.shared);
  constexpr std::size_t kAll[] = {0, 1, 2};
  const std::vector<LikelihoodProfile> profiles = CalcProfiles(id, DescribePlain(id), kAll, 2);
  ASSERT_EQ(profiles.size(), 9u);
  for (std::size_t r = 0; r < 3; ++r) {
    const LikelihoodProfile& k = profiles[3 * r];
    EXPECT_EQ(k.symbol, "k");
    EXPECT_EQ(k.record, static_cast<int>(r));
    const Estimate& own = id.records[r].own_quantities[0];
    const std::optional<double> low = k.Find(-std::sqrt(kProfileRise)), high = k.Find(std::sqrt(kProfileRise));
    ASSERT_TRUE(low && high);
    const double half = 0.5 * (own.high - own.low);
    EXPECT_NEAR(*low, own.low, 0.1 * half);  // one variance factor for all records here, one for each there
    EXPECT_NEAR(*high, own.high, 0.1 * half);
  }
}

TEST(LikelihoodProfile, FindsItsCrossingsOnAKnownCurve) {
  // Root (x - 2)(1 + 0.1 (x - 2)): asymmetric, exactly a polynomial through its points.
  LikelihoodProfile profile;
  const auto root = [](double x) { return (x - 2) * (1 + 0.1 * (x - 2)); };
  for (const double x : {0.5, 1.2, 2.0, 3.1, 4.0}) profile.value.push_back(x), profile.root.push_back(root(x));
  EXPECT_NEAR(profile.Root(2.7), root(2.7), 1e-12);
  ASSERT_TRUE(profile.Find(1.96));
  EXPECT_NEAR(root(*profile.Find(1.96)), 1.96, 1e-9);
  EXPECT_FALSE(profile.Find(40)) << "far beyond the points nothing is known";
  profile.value.resize(2), profile.root.resize(2);
  EXPECT_FALSE(profile.Find(1.96)) << "two points are no profile";
}

}  // namespace
}  // namespace uiclink
