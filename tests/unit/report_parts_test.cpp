// Parts of the report that can be checked by hand: line breaks, local amplitudes, repairs, the covariance of a set.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "identify/diagnose_symptoms.h"
#include "identify/extended_covariance.h"
#include "identify/gain_by_amplitude.h"
#include "identify/screen.h"
#include "identify/uncertainty.h"
#include "model/extended_solver.h"
#include "reports/wrap.h"

namespace uiclink {
namespace {

TEST(Wrap, BreaksAtBlanksBeforeTheColumn) {
  EXPECT_EQ(Wrap("one two three", 0, 7), "one two\nthree");
  EXPECT_EQ(Wrap("one two three", 2, 7), "one\n  two\n  three") << "the first line begins at column 2";
  EXPECT_EQ(Wrap("a  b", 0, 10), "a  b") << "several blanks are kept inside a line";
  EXPECT_EQ(Wrap("unbreakable", 0, 4), "unbreakable");
  EXPECT_EQ(Wrap("", 0, 4), "");
}

TEST(Wrap, CountsCharactersAndNotBytes) { EXPECT_EQ(Wrap("±± ±±", 0, 5), "±± ±±"); }

TEST(Paragraph, IndentsEveryLine) { EXPECT_EQ(Paragraph("one two", 2, 5), "  one\n  two\n"); }

TEST(LocalAmplitudes, AreHalfTheDistanceBetweenNeighbouringExtrema) {
  Record record;
  for (int i = 0; i < 8; ++i) record.t.push_back(i), record.y.push_back(0);
  const FitData data{.record = &record, .first = 1, .size = 7};
  // A zero of 1 mm, which must not matter.
  const std::vector<Extremum> extrema = {{.t = 0.5, .y = 0.021}, {.t = 3, .y = -0.009}, {.t = 5.5, .y = 0.007}};
  const std::vector<double> amplitudes = CalcLocalAmplitudes(data, extrema);
  ASSERT_EQ(amplitudes.size(), 7u);
  for (int i = 0; i < 3; ++i) EXPECT_DOUBLE_EQ(amplitudes[static_cast<std::size_t>(i)], 0.015) << "to 3 s";
  for (int i = 3; i < 7; ++i) EXPECT_DOUBLE_EQ(amplitudes[static_cast<std::size_t>(i)], 0.008) << "and to the end";
  EXPECT_TRUE(CalcLocalAmplitudes(data, std::span(extrema).first(1)).empty());
}

TEST(Repairs, AreFamiliesOrBeginnings) {
  EXPECT_TRUE(IsRepairOf("loss_per_half_cycle", "loss_per_half_cycle_small"));
  EXPECT_TRUE(IsRepairOf("even_harmonics", "second_harmonic"));
  EXPECT_FALSE(IsRepairOf("even_harmonics", "third_harmonic"));
  EXPECT_FALSE(IsRepairOf("backbone_in_time", "backbone_small"));
}

/// A free decay of a link with viscous damping, and its fit.
struct DampedFit {
  Record record;
  FitData data;
  ExtendedResult result;

  DampedFit() {
    Oscillator<double> link;
    link.k = 3.41;
    link.Add({.k = 2.21, .T0 = 0.018});
    const Extension extension({FindEffect("viscous_damping")});
    const std::vector<double> c = {0.012};
    ExtendedTrajectory<double> run;
    EXPECT_EQ(Solve(MakeExtendedOscillator(link, extension, c), 0.025, 0.0, 10.0, &run), SolveStatus::kOk);
    std::mt19937_64 random(7);
    std::normal_distribution<double> noise(0, 1.3e-5);
    record.sampling_hz = 200;
    for (int i = 0; i < 2000; ++i) {
      record.t.push_back(i / record.sampling_hz);
      record.y.push_back(run.y(record.t.back()) + noise(random));
    }
    data = {.record = &record, .first = 0, .size = record.t.size(), .sigma = 1.3e-5};
    ExtendedState state{.link = {}, .shared = c, .own = {{}}};
    state.link.levels.resize(1);
    FromOscillator(link, state.link.levels.data(), &state.link.shape);
    state.link.starts = {{0.025, 0.0, 0.0}};
    const ExtendedOutcome outcome = FitExtended({&data, 1}, Sharing::kLink, extension, state);
    result = Describe({&data, 1}, Sharing::kLink, extension, outcome);
  }

  /// Covariance of (k, k1, T01) by way of that of (levels), scaled to the stated deviation of k.
  Eigen::MatrixXd CalcLinkCovariance() const {
    const Normal normal = CalcNormal({&data, 1}, Sharing::kLink, result.extension, result.outcome.state, 1);
    const Eigen::MatrixXd all = InvertDetermined(normal.gram, 1e-12);
    const Eigen::MatrixXd link = CalcNaturalCovariance(result.link, all.topLeftCorner(3, 3));
    const double std = result.quantities[0].std;
    return std * std / link(0, 0) * link;
  }
};

TEST(ExtendedCovarianceOfASet, AgreesWithWhatIsSaidAboutTheFit) {
  const DampedFit fit;
  const ExtendedCovariance covariance = CalcExtendedCovariance({&fit.data, 1}, fit.result);
  EXPECT_EQ(covariance.order, (std::vector<std::string>{"k", "k1", "T01", "viscous_damping.c"}));
  const Eigen::MatrixXd expected = fit.CalcLinkCovariance();
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = 0; j < 3; ++j) {
      const double scale = std::sqrt(expected(i, i) * expected(j, j));
      // The same linear problem, brought from coordinates to parameters in another way.
      EXPECT_NEAR(covariance.matrix(i, j) / scale, expected(i, j) / scale, 1e-6) << i << ", " << j;
    }
  }
  EXPECT_NEAR(std::sqrt(covariance.matrix(3, 3)) / fit.result.effects.at(0).std, 1, 1e-12);
  // Damping and friction take from the same decay: what one has the other has not.
  EXPECT_LT(covariance.matrix(2, 3), 0);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(covariance.matrix).eigenvalues()(0), 0);
}

}  // namespace
}  // namespace uiclink
