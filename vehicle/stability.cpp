#include "vehicle/stability.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "vehicle/equilibrium.h"
#include "vehicle/wagon_rate.h"

namespace uiclink {
namespace {

using Complex = std::complex<double>;
using Scalar = Dual<static_cast<int>(kMaxState)>;

LinkStates RollingLinks(const Wagon& wagon) {
  LinkStates links;
  for (std::size_t i = 0; i < kCorners; ++i) {
    links.longitudinal[i] = LinkState::Rolling(wagon.longitudinal[i]);
    links.lateral[i] = LinkState::Rolling(wagon.lateral[i]);
  }
  return links;
}

int CountSliders(const Wagon& wagon) {
  std::size_t sliders = 0;
  for (std::size_t i = 0; i < kCorners; ++i)
    sliders += wagon.longitudinal[i].sliders().size() + wagon.lateral[i].sliders().size();
  return static_cast<int>(sliders);
}

bool IsBefore(const Complex& a, const Complex& b) {
  if (a.real() != b.real()) return a.real() > b.real();
  return a.imag() > b.imag();
}

int CountUnstable(const std::vector<Complex>& eigenvalues) {
  return static_cast<int>(std::ranges::count_if(eigenvalues, [](const Complex& e) { return e.real() > 0; }));
}

/// Scales a shape so that its largest displacement is 1; rates do not count.
void Normalize(std::array<Complex, kMaxState>* shape) {
  static constexpr std::array<std::size_t, 14> displacements{wheelset::kX,
                                                             wheelset::kY,
                                                             wheelset::kZ,
                                                             wheelset::kPhi,
                                                             wheelset::kPsi,
                                                             kRearWheelset + wheelset::kX,
                                                             kRearWheelset + wheelset::kY,
                                                             kRearWheelset + wheelset::kZ,
                                                             kRearWheelset + wheelset::kPhi,
                                                             kRearWheelset + wheelset::kPsi,
                                                             kBody + body::kY,
                                                             kBody + body::kZ,
                                                             kBody + body::kPhi,
                                                             kBody + body::kPsi};
  Complex largest(0);
  for (const std::size_t i : displacements)
    if (std::abs((*shape)[i]) > std::abs(largest)) largest = (*shape)[i];
  if (largest == Complex(0)) return;
  for (Complex& component : *shape) component /= largest;
}

/// The crossing between two speeds whose numbers of unstable eigenvalues differ: bisection on whether the eigenvalue
/// that crosses (by rank of its real part) is unstable.
Crossing Locate(const LinearFamily& family, double low, int unstable_low, double high, int unstable_high,
                double tolerance) {
  const auto rank = static_cast<std::size_t>(std::max(unstable_low, unstable_high) - 1);
  const auto real_part = [&](double V) { return CalcEigenvalues(family(V))[rank].real(); };
  const double begin = low, end = high;
  while (high - low > tolerance) {
    const double middle = std::midpoint(low, high);
    if (middle <= low || middle >= high) break;
    ((real_part(middle) > 0) == (unstable_low > unstable_high) ? low : high) = middle;
  }
  Crossing crossing;
  crossing.V = std::midpoint(low, high);
  crossing.to_unstable = unstable_high > unstable_low;
  crossing.mode = CalcModes(family(crossing.V))[rank];
  crossing.frequency_hz = crossing.mode.frequency_hz();
  // Far enough for the difference of two eigenvalues, near enough to stay between the neighbours.
  const double reach = std::min({4e-3 * (end - begin), crossing.V - begin + tolerance, end - crossing.V + tolerance});
  crossing.real_part_slope = (real_part(crossing.V + reach) - real_part(crossing.V - reach)) / (2 * reach);
  return crossing;
}

/// All crossings of an interval, one for each eigenvalue or pair: several are told apart by halving.
void LocateAll(const LinearFamily& family, double low, int unstable_low, double high, int unstable_high,
               double tolerance, std::vector<Crossing>* crossings) {
  if (unstable_low == unstable_high) return;
  if (std::abs(unstable_high - unstable_low) <= 2 || high - low <= tolerance) {
    crossings->push_back(Locate(family, low, unstable_low, high, unstable_high, tolerance));
    return;
  }
  const double middle = std::midpoint(low, high);
  const int unstable = CountUnstable(CalcEigenvalues(family(middle)));
  LocateAll(family, low, unstable_low, middle, unstable, tolerance, crossings);
  LocateAll(family, middle, unstable, high, unstable_high, tolerance, crossings);
}

void Check(const StabilityOptions& options) {
  if (!(std::isfinite(options.from) && options.to > options.from && std::isfinite(options.to)))
    throw std::invalid_argument("expected from < to");
  if (!(options.step > 0 && options.tolerance > 0))
    throw std::invalid_argument("expected a step and a tolerance above 0");
}

}  // namespace

double LinearMode::frequency_hz() const { return std::abs(lambda.imag()) / (2 * std::numbers::pi); }

LinearWagon Linearize(const Wagon& wagon, double V) {
  LinearWagon linear;
  linear.V = V;
  linear.equilibrium = FindEquilibrium(wagon, V);
  StateVector<Scalar> x, rate;
  for (std::size_t i = 0; i < kMaxState; ++i) x[i] = Scalar(linear.equilibrium.x[i], static_cast<int>(i));
  CalcRate(wagon, V, RollingLinks(wagon), x, &rate);
  linear.jacobian.resize(kMotions, kMotions);
  for (std::size_t i = 0; i < kMotions; ++i)
    linear.jacobian.row(static_cast<Eigen::Index>(i)) = rate[i].v.head<kMotions>();
  linear.structural_zeros = CountSliders(wagon) + (wagon.options.suspension == Suspension::kLeaf ? 4 : 0);
  return linear;
}

std::vector<Complex> CalcEigenvalues(const LinearWagon& linear) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(linear.jacobian, false);
  const auto& values = solver.eigenvalues();
  std::vector<Complex> eigenvalues(values.begin(), values.end());
  std::ranges::sort(eigenvalues, IsBefore);
  return eigenvalues;
}

std::vector<LinearMode> CalcModes(const LinearWagon& linear) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(linear.jacobian, true);
  const Eigen::MatrixXcd vectors = solver.eigenvectors();
  std::vector<LinearMode> modes(static_cast<std::size_t>(vectors.cols()));
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    modes[i].lambda = solver.eigenvalues()[column];
    for (std::size_t j = 0; j < kMotions; ++j) modes[i].shape[j] = vectors(static_cast<Eigen::Index>(j), column);
    Normalize(&modes[i].shape);
  }
  std::ranges::sort(modes, [](const LinearMode& a, const LinearMode& b) { return IsBefore(a.lambda, b.lambda); });
  return modes;
}

StabilityResult FindCrossings(const LinearFamily& family, const StabilityOptions& options) {
  Check(options);
  StabilityResult result;
  const auto steps = static_cast<int>(std::ceil((options.to - options.from) / options.step - 1e-9));
  double before = options.from;
  int unstable_before = 0;
  for (int i = 0; i <= steps; ++i) {
    const double V = std::min(options.from + i * options.step, options.to);
    const LinearWagon linear = family(V);
    const std::vector<Complex> eigenvalues = CalcEigenvalues(linear);
    const int unstable = CountUnstable(eigenvalues);
    if (options.on_speed) options.on_speed(V, eigenvalues);
    if (i == 0) {
      result.unstable_at_start = unstable;
      result.structural_zeros = linear.structural_zeros;
    } else {
      LocateAll(family, before, unstable_before, V, unstable, options.tolerance, &result.crossings);
    }
    result.searched_to = V;
    if (options.first_only && result.unstable_at_start == 0 && !result.crossings.empty()) break;
    before = V;
    unstable_before = unstable;
  }
  return result;
}

StabilityResult FindCrossings(const Wagon& wagon, const StabilityOptions& options) {
  if (!(options.from > 0)) throw std::invalid_argument("expected speeds 0 < from < to");
  StabilityResult result = FindCrossings([&wagon](double V) { return Linearize(wagon, V); }, options);
  if (result.unstable_at_start == 0 && !result.crossings.empty())
    result.linear_critical_speed = result.crossings.front().V;
  return result;
}

}  // namespace uiclink
