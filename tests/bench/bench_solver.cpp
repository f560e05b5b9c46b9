// One record of 15 s at 200 Hz: the event solver against CVODE with root-finding at rtol 1e-8, and, with derivatives
// with respect to all parameters and the start displacement, against the forward sensitivities of CVODES.

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "model/event_solver.h"
#include "tests/bench/ratio.h"
#include "tests/support/cvode_reference.h"

namespace uiclink {
namespace {

constexpr double kDuration = 15;
constexpr double kReleaseAt = 0.025;  // [m]
const SampleTimes kSamples{.first = 0, .step = 0.005, .size = 3001};

Oscillator<double> MakeLink(double k, std::initializer_list<Slider<double>> sliders) {
  Oscillator<double> oscillator;
  oscillator.k = k;
  for (const Slider<double>& slider : sliders) oscillator.Add(slider);
  return oscillator;
}

template <int n>
struct Record {
  static constexpr int kDerivatives = 2 * n + 2;
  using Dual = ceres::Jet<double, kDerivatives>;

  explicit Record(const Oscillator<double>& link) : oscillator(link) {}

  Oscillator<double> oscillator;
  Oscillator<Dual> dual = WithDerivatives<kDerivatives>(oscillator);
  State<double> start = AtExtremum(oscillator, kReleaseAt);
  State<Dual> dual_start = AtExtremum(dual, Dual(kReleaseAt, kDerivatives - 1));
  Trajectory<double> run;
  Trajectory<Dual> dual_run;
  std::vector<double> y = std::vector<double>(kSamples.size);
  std::vector<double> v = y, cvode_y = y;
  std::vector<double> dy = std::vector<double>(kSamples.size * kDerivatives);
  std::vector<double> cvode_dy = dy;
  std::unique_ptr<CvodeReference> cvode;

  void Solve() {
    uiclink::Solve(oscillator, start, kDuration, &run);
    CalcDisplacements(run, kSamples, y);
  }
  void SolveWithDerivatives() {
    uiclink::Solve(dual, dual_start, kDuration, &dual_run);
    CalcDisplacements(dual_run, kSamples, y, v, dy);
  }
  void RunCvode() { cvode->Run(oscillator, start, kSamples, cvode_y); }
  void RunCvodes() { cvode->Run(dual, dual_start, kSamples, cvode_y, cvode_dy); }

  double Difference() const {
    double worst = 0;
    for (std::size_t i = 0; i < y.size(); ++i) worst = std::max(worst, std::abs(y[i] - cvode_y[i]));
    return worst;
  }
  /// Largest difference between derivatives, as a share of the largest derivative of that column.
  double DerivativeDifference() const {
    double worst = 0;
    for (std::size_t p = 0; p < dy.size() / kSamples.size; ++p) {
      double scale = 0, difference = 0;
      for (std::size_t i = p * kSamples.size; i < (p + 1) * kSamples.size; ++i) {
        scale = std::max(scale, std::abs(dy[i]));
        difference = std::max(difference, std::abs(dy[i] - cvode_dy[i]));
      }
      worst = std::max(worst, difference / scale);
    }
    return worst;
  }
};

/// Every way in which CVODES can be set up for this problem, each at its default error control (which leaves the
/// derivatives out) and at a tolerance of 1e-8, absolute 1e-10.
std::vector<CvodeOptions> Configurations(bool derivatives, const Oscillator<double>& oscillator) {
  std::vector<CvodeOptions> all;
  CvodeOptions options{.rtol = 1e-8, .atol = 1e-10, .control_derivatives = false, .parameter_scale = {oscillator.k}};
  for (const Slider<double>& slider : oscillator.sliders()) options.parameter_scale.push_back(slider.k);
  for (const Slider<double>& slider : oscillator.sliders()) options.parameter_scale.push_back(slider.T0);
  options.parameter_scale.push_back(kReleaseAt);
  for (const auto method : {CvodeOptions::Method::kAdams, CvodeOptions::Method::kBdf}) {
    for (const auto corrector : {CvodeOptions::Corrector::kFixedPoint, CvodeOptions::Corrector::kNewton}) {
      for (const auto way : {CvodeOptions::Sensitivities::kSimultaneous, CvodeOptions::Sensitivities::kStaggered}) {
        if (!derivatives && way == CvodeOptions::Sensitivities::kStaggered) continue;
        options.method = method;
        options.corrector = corrector;
        options.sensitivities = way;
        all.push_back(options);
      }
    }
  }
  return all;
}

std::string Describe(const CvodeOptions& options, bool derivatives) {
  std::string text = derivatives ? "CVODES (" : "CVODE (";
  text += options.method == CvodeOptions::Method::kAdams ? "Adams" : "BDF";
  text += options.corrector == CvodeOptions::Corrector::kNewton ? ", Newton" : ", fixed point";
  if (derivatives)
    text += options.sensitivities == CvodeOptions::Sensitivities::kStaggered ? ", staggered" : ", simultaneous";
  return text + "), its fastest set-up here";
}

/// Sets the record's CVODE up in the way that is fastest for it; returns the words for it.
template <int n>
std::string ChooseFastest(Record<n>* record, bool derivatives) {
  double least = std::numeric_limits<double>::infinity();
  CvodeOptions best;
  const int columns = derivatives ? Record<n>::kDerivatives : 0;
  for (const CvodeOptions& options : Configurations(derivatives, record->oscillator)) {
    record->cvode = std::make_unique<CvodeReference>(n, columns, options);
    const Side side = Timed("", 1, [&] { derivatives ? record->RunCvodes() : record->RunCvode(); });
    double seconds = side.seconds();
    for (int repeat = 0; repeat < 2; ++repeat) seconds = std::min(seconds, side.seconds());
    if (seconds >= least) continue;
    least = seconds;
    best = options;
  }
  record->cvode = std::make_unique<CvodeReference>(n, columns, best);
  return Describe(best, derivatives);
}

constexpr int kRuns = 50;  // of ours for one of theirs

template <int n>
void AddComparisons(const std::string& name, const Oscillator<double>& link, std::vector<Comparison>* comparisons) {
  auto plain = std::make_shared<Record<n>>(link);
  comparisons->push_back({.name = name + ": record",
                          .ours = Timed("exact", kRuns, [plain] { plain->Solve(); }),
                          .theirs = Timed(ChooseFastest(plain.get(), false), 1, [plain] { plain->RunCvode(); }),
                          .least_ratio = 100,
                          .difference = [plain] { return plain->Difference(); },
                          .largest_difference = 1e-6,  // what rtol 1e-8 leaves of 25 mm, and below any sensor's noise
                          .unit = "m"});
  auto dual = std::make_shared<Record<n>>(link);
  comparisons->push_back(
      {.name = name + ": with " + std::to_string(Record<n>::kDerivatives) + " derivatives",
       .ours = Timed("exact", kRuns, [dual] { dual->SolveWithDerivatives(); }),
       .theirs = Timed(ChooseFastest(dual.get(), true), 1, [dual] { dual->RunCvodes(); }),
       .least_ratio = 30,
       .difference = [dual] { return dual->DerivativeDifference(); },
       .largest_difference = 1e-3,  // CVODES does not control this error by default; a fit does not need more
       .unit = "of the largest derivative"});
}

int Main(int argc, char** argv) {
  std::vector<Comparison> comparisons;
  // Parameters: tables 4.1 and 4.2 of the thesis.
  AddComparisons<1>("set 1 lateral", MakeLink(4.2010, {{1.4222, 0.014}}), &comparisons);
  AddComparisons<1>("set 2 lateral", MakeLink(3.413, {{10.503, 0.018}}), &comparisons);
  AddComparisons<4>("set 1 longitudinal", MakeLink(6.4763, {{2.00, 6e-3}, {0.50, 3e-3}, {0.37, 2e-3}, {0.50, 2e-3}}),
                    &comparisons);
  AddComparisons<4>("set 2 longitudinal",
                    MakeLink(5.50, {{3.44, 6.98e-3}, {2.00, 5.11e-3}, {0.33, 0.91e-3}, {1.90, 7.16e-3}}), &comparisons);
  return RunComparisons(argc, argv, comparisons);
}

}  // namespace
}  // namespace uiclink

int main(int argc, char** argv) { return uiclink::Main(argc, argv); }
