#include "dynamics/lyapunov.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>
#include <span>
#include <stdexcept>
#include <vector>

namespace uiclink {
namespace {

using Eigen::VectorXd;

void CheckOptions(const LyapunovOptions& o) {
  if (!(o.interval > 0)) throw std::invalid_argument("FindLargestExponent: the interval must be positive");
  if (!(o.deviation > 0)) throw std::invalid_argument("FindLargestExponent: the deviation must be positive");
  if (o.blocks < 2 || o.intervals < o.blocks || o.discarded < 0)
    throw std::invalid_argument("FindLargestExponent: at least two blocks of one interval each are needed");
}

/// Moves a state with a small deviation beside it.
class Pair {
 public:
  Pair(Flow& flow, const VectorXd& start, double lambda, const LyapunovOptions& options)
      : flow_(flow),
        lambda_(lambda),
        options_(options),
        interval_(flow.ForcedPeriod(lambda).value_or(options.interval)),
        random_(options.seed),
        state_(start),
        deviation_(DrawDirection()) {}

  /// log(|dz(end)| / |dz(begin)|) of one interval; the deviation has its norm again afterwards. A deviation that is
  /// wiped out gives way to a new one and returns nothing.
  std::optional<double> Advance() {
    const bool derivative = options_.method == DeviationMethod::kDerivative;
    const Passage passage =
        flow_.Pass(state_, interval_, lambda_, derivative ? Flow::Derivatives::kAll : Flow::Derivatives::kNone);
    ++passages_;
    VectorXd moved;
    if (derivative) {
      moved = passage.by_start * deviation_;
    } else {
      VectorXd neighbour = state_ + deviation_;
      flow_.Follow(state_, passage.slaved_start, &neighbour);
      moved = flow_.Pass(neighbour, interval_, lambda_, Flow::Derivatives::kNone).end - passage.end;
      ++passages_;
    }
    state_ = passage.end;
    const double growth = CalcNorm(moved) / options_.deviation;
    if (!(growth > kWipedOut)) {
      deviation_ = DrawDirection();
      return std::nullopt;
    }
    deviation_ = moved / growth;
    return std::log(growth);
  }

  double interval() const { return interval_; }
  long passages() const { return passages_; }
  const VectorXd& state() const { return state_; }

 private:
  /// An interval in which a deviation shrinks by this much has wiped it out; rates of thousands a second are none.
  static constexpr double kWipedOut = 1e-9;

  double CalcNorm(const VectorXd& d) const { return std::sqrt((d.array() / flow_.scales().array()).square().mean()); }

  VectorXd DrawDirection() {
    std::normal_distribution<double> normal;
    VectorXd direction(flow_.size());
    for (double& x : direction) x = normal(random_);
    direction.array() *= flow_.scales().array();
    return direction * (options_.deviation / CalcNorm(direction));
  }

  Flow& flow_;
  double lambda_;
  const LyapunovOptions& options_;
  double interval_;
  std::mt19937_64 random_;
  VectorXd state_, deviation_;
  long passages_ = 0;
};

double CalcMean(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Standard error of the mean of a correlated sequence, by the scatter of the means of its blocks.
double CalcBlockError(std::span<const double> values, std::size_t blocks) {
  blocks = std::min(blocks, values.size());
  if (blocks < 2) return 0;
  const std::size_t size = values.size() / blocks;
  std::vector<double> means;
  for (std::size_t i = 0; i < blocks; ++i) means.push_back(CalcMean(values.subspan(i * size, size)));
  const double mean = CalcMean(means);
  double sum = 0;
  for (const double m : means) sum += (m - mean) * (m - mean);
  return std::sqrt(sum / static_cast<double>(blocks * (blocks - 1)));
}

}  // namespace

LyapunovResult FindLargestExponent(Flow& flow, const VectorXd& start, double lambda, const LyapunovOptions& options) {
  CheckOptions(options);
  Pair pair(flow, start, lambda, options);
  std::vector<double> growth;
  growth.reserve(static_cast<std::size_t>(options.intervals));
  for (int i = 0, lost = 0; static_cast<int>(growth.size()) < options.intervals; ++i) {
    const std::optional<double> g = pair.Advance();
    if (!g && ++lost > std::max(10, i / 2))
      throw std::runtime_error("FindLargestExponent: deviations are wiped out within an interval; shorten it");
    if (g && i >= options.discarded) growth.push_back(*g / pair.interval());
    if (options.on_interval && !options.on_interval(i + 1)) break;
  }
  LyapunovResult result;
  result.passages = pair.passages();
  result.end = pair.state();
  result.intervals = static_cast<int>(growth.size());
  if (growth.empty()) return result;
  result.duration = static_cast<double>(growth.size()) * pair.interval();
  result.exponent = CalcMean(growth);
  result.error = CalcBlockError(growth, static_cast<std::size_t>(options.blocks));
  return result;
}

}  // namespace uiclink
