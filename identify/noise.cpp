#include "identify/noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <stdexcept>
#include <vector>

#include "identify/upper_median.h"

namespace uiclink {
namespace {

// --- noise about a local polynomial --------------------------------------------------------------------------------

constexpr double kBlockSeconds = 0.1;  // a tenth of a period of the links' motion (0.8 to 2 Hz), or a fifth
constexpr std::size_t kSmallestBlock = 15;
constexpr std::size_t kHighestDegree = 10;

/// One block, taken apart into orthonormal polynomials of time.
struct Block {
  std::array<double, kHighestDegree + 1> power{};  ///< squared coefficient by degree
  double rest = 0;                                 ///< sum of squares beyond the highest degree
  double range = 0;                                ///< largest minus smallest reading
};

/// Projects y on polynomials that are orthonormal over the times of this block (Forsythe's recurrence: t need not be
/// equally spaced). Each coefficient that is not motion has the variance of a single reading.
Block Decompose(std::span<const double> t, std::span<const double> y, std::size_t highest_degree) {
  const std::size_t n = y.size();
  const double middle = 0.5 * (t.front() + t.back());
  const double half = 0.5 * (t.back() - t.front());
  std::vector<double> x(n);
  std::vector<double> residual(y.begin(), y.end());
  std::vector<double> before(n, 0.0);
  std::vector<double> basis(n, 1 / std::sqrt(static_cast<double>(n)));
  for (std::size_t i = 0; i < n; ++i) x[i] = (t[i] - middle) / half;

  Block block;
  double back = 0;  // <basis_k, x basis_(k-1)>
  for (std::size_t degree = 0; degree <= highest_degree; ++degree) {
    double coefficient = 0;
    double shift = 0;
    for (std::size_t i = 0; i < n; ++i) {
      coefficient += basis[i] * residual[i];
      shift += x[i] * basis[i] * basis[i];
    }
    block.power[degree] = coefficient * coefficient;
    double norm2 = 0;
    for (std::size_t i = 0; i < n; ++i) {
      residual[i] -= coefficient * basis[i];
      before[i] = (x[i] - shift) * basis[i] - back * before[i];
      norm2 += before[i] * before[i];
    }
    back = std::sqrt(norm2);
    for (double& value : before) value /= back;
    std::swap(before, basis);
  }
  for (const double r : residual) block.rest += r * r;
  const auto [low, high] = std::minmax_element(y.begin(), y.end());
  block.range = *high - *low;
  return block;
}

struct Blocks {
  std::vector<Block> blocks;
  std::size_t samples = 0;  ///< in each
  std::size_t highest_degree = 0;

  /// Variance of a reading in one block when the motion is a polynomial of this degree.
  double Variance(const Block& block, std::size_t degree) const {
    double sum = block.rest;
    for (std::size_t k = degree + 1; k <= highest_degree; ++k) sum += block.power[k];
    return sum / DegreesOfFreedom(degree);
  }
  double DegreesOfFreedom(std::size_t degree) const { return static_cast<double>(samples - degree - 1); }
};

/// Half-overlapping blocks: the ends of each, where a polynomial binds most, are the middle of another.
Blocks CutIntoBlocks(std::span<const double> t, std::span<const double> y) {
  const auto rate = static_cast<double>(t.size() - 1) / (t.back() - t.front());
  Blocks cut;
  // Compared as doubles: a rate of 1e300 must not overflow an integer.
  const double wanted = std::clamp(std::round(kBlockSeconds * rate) + 1, static_cast<double>(kSmallestBlock),
                                   static_cast<double>(t.size()));
  cut.samples = static_cast<std::size_t>(wanted);
  cut.highest_degree = std::min(kHighestDegree, cut.samples / 2);
  for (std::size_t start = 0; start + cut.samples <= t.size(); start += std::max<std::size_t>(cut.samples / 2, 1)) {
    cut.blocks.push_back(Decompose(t.subspan(start, cut.samples), y.subspan(start, cut.samples), cut.highest_degree));
  }
  return cut;
}

/// Quantile of chi-square over its degrees of freedom, by Wilson and Hilferty (1931); below 1 % off for nu >= 4.
double ChiSquareRatio(double nu, double normal_quantile) {
  const double spread = 2 / (9 * nu);
  const double root = 1 - spread + normal_quantile * std::sqrt(spread);
  return root * root * root;
}

/// E[X | X < c] / nu for chi-square X:  1 - (c/2)^(nu/2) e^(-c/2) / (Gamma(nu/2 + 1) F(c)).
double MeanBelow(double nu, double c, double share_below) {
  return 1 - std::exp(nu / 2 * std::log(c / 2) - c / 2 - std::lgamma(nu / 2 + 1)) / share_below;
}

/// Variance common to most of the blocks, and the limit above which a block does not share it.
struct CommonVariance {
  double variance = 0;
  double limit = 0;
};

/// Mean of the block variances below the 99.9 % point of their distribution, starting from their median.
CommonVariance FindCommonVariance(const std::vector<double>& variances, double nu) {
  constexpr double kCut = 3.0902;  // normal quantile of 0.999
  constexpr double kShare = 0.999;
  const double cut = ChiSquareRatio(nu, kCut);
  const double correction = MeanBelow(nu, nu * cut, kShare);
  CommonVariance common;
  common.variance = UpperMedian(variances) / ChiSquareRatio(nu, 0);
  constexpr int kMostRounds = 50;  // the set kept settles within a few; it can cycle between two sets of equal worth
  for (int round = 0; round < kMostRounds; ++round) {
    common.limit = cut * common.variance;
    double sum = 0;
    double count = 0;
    for (const double v : variances) {
      if (v > common.limit) continue;
      sum += v;
      ++count;
    }
    if (count == 0) return common;
    const double next = sum / count / correction;
    if (next == common.variance) return common;
    common.variance = next;
  }
  return common;
}

std::vector<double> BlockVariances(const Blocks& cut, std::size_t degree) {
  std::vector<double> variances;
  variances.reserve(cut.blocks.size());
  for (const Block& block : cut.blocks) variances.push_back(cut.Variance(block, degree));
  return variances;
}

/// The degree of the motion: coefficients above it are as small as noise, in the mean over the blocks without a kink.
std::size_t FindDegree(const Blocks& cut) {
  const std::vector<double> variances = BlockVariances(cut, cut.highest_degree);
  const CommonVariance common = FindCommonVariance(variances, cut.DegreesOfFreedom(cut.highest_degree));
  std::size_t degree = cut.highest_degree;
  while (degree > 1) {
    double power = 0;
    double count = 0;
    for (std::size_t i = 0; i < cut.blocks.size(); ++i) {
      if (variances[i] > common.limit) continue;
      power += cut.blocks[i].power[degree];
      ++count;
    }
    // Three standard deviations of a mean of squares; overlapping blocks are worth about half as many.
    if (!(power <= common.variance * (count + 3 * std::sqrt(4 * count)))) break;
    --degree;
  }
  // One degree more than the test asks for: what it cannot see there is smaller still by the next degree.
  return std::min(degree + 1, cut.highest_degree);
}

/// Leaves out blocks that stand still, or nearly so on the lattice, as long as a tenth of the record remains.
void KeepMovingBlocks(double quantum, Blocks* cut) {
  constexpr double kSteps = 4;
  std::vector<Block> moving;
  for (const Block& block : cut->blocks) {
    if (block.range > 0 && block.range >= kSteps * quantum) moving.push_back(block);
  }
  if (10 * moving.size() >= cut->blocks.size()) cut->blocks = std::move(moving);
}

// --- the lattice of the readings --------------------------------------------------------------------------------

std::vector<double> DistinctValues(std::span<const double> y) {
  std::vector<double> values(y.begin(), y.end());
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

std::vector<double> Gaps(const std::vector<double>& levels) {
  std::vector<double> gaps(levels.size() - 1);
  for (std::size_t i = 0; i < gaps.size(); ++i) gaps[i] = levels[i + 1] - levels[i];
  return gaps;
}

/// Largest step of which all gaps are multiples within `tolerance`, by Euclid's algorithm; 0 where there is none that
/// is well above the tolerance.
double CommonStep(std::vector<double> gaps, double tolerance) {
  std::sort(gaps.begin(), gaps.end());
  double step = gaps.front();
  for (const double gap : gaps) {
    double a = gap;
    double b = step;
    while (true) {  // gcd(a, b); b shrinks by at least half in each round
      const double multiple = std::round(a / b);
      const double rest = std::abs(a - multiple * b);
      const double error = tolerance * (1 + multiple);
      if (error > 0.05 * b) return 0;  // any gap would seem to be a multiple
      if (rest <= error) break;
      a = b;
      b = rest;
    }
    step = gap / std::round(gap / b);  // the error of one gap, spread over many steps
  }
  return step;
}

/// A lattice: levels offset + n step.
struct Lattice {
  double step;
  double offset;
  double largest_deviation;  ///< of a level from it
};

/// Least-squares lattice through levels, whose numbers are counted from `start` in steps of `step`.
Lattice FitLattice(std::span<const double> levels, double start, double step) {
  double n = 0, sum_k = 0, sum_kk = 0, sum_y = 0, sum_ky = 0;
  for (const double level : levels) {
    const double k = std::round((level - start) / step);
    n += 1;
    sum_k += k;
    sum_kk += k * k;
    sum_y += level - start;
    sum_ky += k * (level - start);
  }
  const double determinant = n * sum_kk - sum_k * sum_k;
  if (!(determinant > 0)) return {step, start, step};  // all levels on one number: no lattice
  Lattice fit{(n * sum_ky - sum_k * sum_y) / determinant, 0, 0};
  fit.offset = start + (sum_y - fit.step * sum_k) / n;
  for (const double level : levels) {
    const double k = std::round((level - start) / step);
    fit.largest_deviation = std::max(fit.largest_deviation, std::abs(level - fit.offset - k * fit.step));
  }
  return fit;
}

/// First of `count` levels that lie closest together: there the numbers are counted most safely.
std::size_t FindDensest(std::span<const double> levels, std::size_t count) {
  std::size_t best = 0;
  for (std::size_t i = 0; i + count <= levels.size(); ++i) {
    if (levels[i + count - 1] - levels[i] < levels[best + count - 1] - levels[best]) best = i;
  }
  return best;
}

/// Step of the lattice near `step` that holds all levels within `rounding`; empty if there is none. Starts with a few
/// levels; each fit makes the step known well enough to number levels half as far again.
std::optional<double> GrowLattice(std::span<const double> levels, double step, double rounding) {
  const std::size_t seed_count = std::min<std::size_t>(8, levels.size());
  const std::size_t seed = FindDensest(levels, seed_count);
  double start = levels[seed];
  double low = levels[seed];
  double high = levels[seed + seed_count - 1];
  while (true) {
    const auto first = std::lower_bound(levels.begin(), levels.end(), low);
    const auto last = std::upper_bound(first, levels.end(), high);
    const Lattice lattice = FitLattice({first, last}, start, step);
    if (!(lattice.largest_deviation <= rounding)) return std::nullopt;
    step = lattice.step;
    start = lattice.offset;
    if (first == levels.begin() && last == levels.end()) return step;
    const double more = 0.25 * (high - low);
    low -= more;
    high += more;
  }
}

/// Mean of the gaps that are as small as the smallest, give or take the print's rounding at both ends.
double MeanSmallestGap(const std::vector<double>& gaps, double print) {
  const double limit = *std::min_element(gaps.begin(), gaps.end()) + 1.5 * print;
  double sum = 0;
  double count = 0;
  for (const double gap : gaps) {
    if (gap > limit) continue;
    sum += gap;
    ++count;
  }
  return sum / count;
}

/// The step behind readings that were rounded to multiples of `print`; empty if there is none that can be told from it.
std::optional<double> FindCoarserStep(const std::vector<double>& levels, const std::vector<double>& gaps,
                                      double print) {
  constexpr double kFinest = 2.5;        // finer than this, in units of the print, and the two lattices look alike
  constexpr int kMostMissing = 4;        // no two adjacent levels occur: the smallest gap is then 2, 3, ... steps
  constexpr double kChance = 1e-6;       // that levels without a lattice seem to have one
  const double rounding = 0.75 * print;  // half a print step, and the error of a line through eight such levels
  const double smallest_gap = MeanSmallestGap(gaps, print);
  for (int divisor = 1; divisor <= kMostMissing; ++divisor) {
    const double guess = smallest_gap / divisor;
    if (guess < kFinest * print) break;
    const double chance = std::pow(2 * rounding / guess, static_cast<double>(levels.size()));
    if (chance > kChance) continue;
    if (const std::optional<double> step = GrowLattice(levels, guess, rounding)) return step;
  }
  return std::nullopt;
}

}  // namespace

double FindQuantum(std::span<const double> y) {
  const std::vector<double> levels = DistinctValues(y);
  if (levels.size() < 2) return 0;
  const std::vector<double> gaps = Gaps(levels);
  // A reading is off by its conversion to binary and to metres, 2 x 1.1e-16; a gap has two ends. Twice that, because a
  // remainder of Euclid's algorithm has two gaps in it.
  const double tolerance = 1e-15 * std::max(std::abs(levels.front()), std::abs(levels.back()));
  const double print = CommonStep(gaps, tolerance);
  // A print so fine that doubles blur it still leaves the lattice behind it to be seen.
  constexpr double kBlurred = 0.05;
  const double rounding = print > 0 ? print : kBlurred * *std::min_element(gaps.begin(), gaps.end());
  return FindCoarserStep(levels, gaps, rounding).value_or(print);
}

Noise EstimateNoise(std::span<const double> t, std::span<const double> y) {
  constexpr std::size_t kFewest = 16;
  const auto is_sane = [](double value) { return std::abs(value) < 1e100; };  // its square must not overflow
  if (t.size() != y.size() || y.size() < kFewest) {
    throw std::invalid_argument(fmt::format("EstimateNoise: {} times and {} readings, must be as many and at least {}",
                                            t.size(), y.size(), kFewest));
  }
  if (!std::all_of(y.begin(), y.end(), is_sane) || !std::all_of(t.begin(), t.end(), is_sane) ||
      std::adjacent_find(t.begin(), t.end(), std::greater_equal<>()) != t.end()) {
    throw std::invalid_argument("EstimateNoise: times and readings must be finite (below 1e100), times must increase");
  }
  Noise noise;
  noise.quantum = FindQuantum(y);
  Blocks cut = CutIntoBlocks(t, y);
  KeepMovingBlocks(noise.quantum, &cut);
  const std::size_t degree = FindDegree(cut);
  const CommonVariance common = FindCommonVariance(BlockVariances(cut, degree), cut.DegreesOfFreedom(degree));
  noise.sigma = std::max(std::sqrt(common.variance), noise.quantum / std::sqrt(12.0));
  return noise;
}

Noise EstimateNoise(std::span<const double> t, std::span<const double> y, std::span<const double> stated) {
  Noise noise = EstimateNoise(t, y);
  double square = 0;
  for (const double s : stated) square += s * s;
  if (!stated.empty()) noise.sigma = std::max(noise.sigma, std::sqrt(square / static_cast<double>(stated.size())));
  return noise;
}

}  // namespace uiclink
