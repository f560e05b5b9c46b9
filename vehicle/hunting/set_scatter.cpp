#include "vehicle/hunting/set_scatter.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>
#include <unsupported/Eigen/SpecialFunctions>

#include "model/effect.h"

namespace uiclink {
namespace {

constexpr std::array kDirections{Direction::kLateral, Direction::kLongitudinal};
constexpr int kMostAttempts = 10000;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

DirectionParameters& Of(CornerLinks* links, Direction direction) {
  return direction == Direction::kLateral ? links->lateral : links->longitudinal;
}
const DirectionParameters& Of(const CornerLinks& links, Direction direction) {
  return direction == Direction::kLateral ? links.lateral : links.longitudinal;
}

/// The same numbers: the same measurement.
bool IsSame(const DirectionParameters& a, const DirectionParameters& b) {
  const auto slider = [](const Slider<double>& p, const Slider<double>& q) { return p.k == q.k && p.T0 == q.T0; };
  const auto effect = [](const EffectValues& p, const EffectValues& q) {
    return p.id == q.id && p.parameters == q.parameters;
  };
  return a.k == b.k && std::ranges::equal(a.sliders, b.sliders, slider) &&
         std::ranges::equal(a.effects, b.effects, effect) && a.covariance.has_value() == b.covariance.has_value() &&
         (!a.covariance ||
          (a.covariance->order == b.covariance->order && a.covariance->matrix == b.covariance->matrix &&
           a.covariance->coverage == b.covariance->coverage));
}

bool IsFriction(std::string_view symbol) { return symbol.starts_with("T0"); }

/// "lateral k + sum k_i", "lateral T0", "lateral rolling_friction".
std::string GroupOf(Direction direction, const std::string& symbol) {
  const std::size_t dot = symbol.find('.');
  const std::string what = dot != std::string::npos ? symbol.substr(0, dot)
                           : IsFriction(symbol)     ? std::string("T0")
                                                    : std::string("k + sum k_i");
  return fmt::format("{} {}", Name(direction), what);
}

/// Physical bounds; a value that an effect may have at its bound stays possible.
void SetBounds(UncertainParameter* parameter) {
  parameter->low = 0;
  parameter->high = kInfinite;
  const std::size_t dot = parameter->symbol.find('.');
  if (dot == std::string::npos) return;
  const Effect* effect = FindEffect(std::string_view(parameter->symbol).substr(0, dot));
  if (effect == nullptr) return;  // the wagon says so
  for (const EffectParameter& p : effect->parameters) {
    if (p.symbol != parameter->symbol.substr(dot + 1)) continue;
    parameter->low = p.low;
    parameter->high = p.high;
  }
}

bool IsInside(const UncertainParameter& parameter, double value) {
  const bool effect = parameter.symbol.find('.') != std::string::npos;
  return effect ? value >= parameter.low && value <= parameter.high : value > parameter.low;
}

/// L with L L' = C. Through correlations, since variances differ by many powers of ten; C may be singular.
Eigen::MatrixXd CalcRoot(const Eigen::MatrixXd& C, Direction direction) {
  constexpr double kSlack = 1e-6;  // of a correlation: a file may have been rounded
  const Eigen::VectorXd std = C.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd per_std = std.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(per_std.asDiagonal() * C * per_std.asDiagonal());
  if (solver.eigenvalues().minCoeff() < -kSlack) {
    throw std::invalid_argument(
        fmt::format("the covariance of the {} direction is none: a combination of its parameters has a variance of "
                    "{:.2g} relative to theirs",
                    Name(direction), solver.eigenvalues().minCoeff()));
  }
  return std.asDiagonal() * solver.eigenvectors() *
         solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal().toDenseMatrix();
}

/// Numbers between 0 and 1, the same on every machine.
class Uniform {
 public:
  Uniform(std::uint64_t seed, std::uint64_t stream) {
    std::seed_seq sequence{seed & 0xffffffffU, seed >> 32U, stream};
    random_.seed(sequence);
  }
  double operator()() { return (static_cast<double>(random_() >> 11U) + 0.5) * 0x1p-53; }
  std::size_t Below(std::size_t n) { return static_cast<std::size_t>(random_() % n); }

 private:
  std::mt19937_64 random_;
};

double ToNormal(double probability) { return Eigen::numext::ndtri(probability); }

/// Independent standard normal numbers: a row per draw.
Eigen::MatrixXd DrawNormal(Sampling sampling, Eigen::Index draws, Eigen::Index size, Uniform* uniform) {
  Eigen::MatrixXd z(draws, size);
  if (sampling == Sampling::kLatinHypercube) {
    std::vector<std::size_t> order(static_cast<std::size_t>(draws));
    for (Eigen::Index j = 0; j < size; ++j) {
      std::iota(order.begin(), order.end(), std::size_t{0});
      for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[uniform->Below(i)]);
      for (Eigen::Index i = 0; i < draws; ++i)
        z(i, j) = ToNormal((static_cast<double>(order[static_cast<std::size_t>(i)]) + (*uniform)()) /
                           static_cast<double>(draws));
    }
    return z;
  }
  for (Eigen::Index i = 0; i < draws; ++i) {
    const bool mirrored = sampling == Sampling::kAntithetic && i % 2 == 1;
    for (Eigen::Index j = 0; j < size; ++j) z(i, j) = mirrored ? -z(i - 1, j) : ToNormal((*uniform)());
  }
  return z;
}

/// As Wagon has them with the linear suspension.
DirectionParameters WithoutSliders(const DirectionParameters& links) {
  DirectionParameters springs;
  springs.k = links.k + links.SumOfSliderStiffness();
  return springs;
}

}  // namespace

/// Parameters that are drawn together: x = m + L z.
struct SetScatter::Block {
  std::size_t first = 0;
  Eigen::MatrixXd root;
  std::uint64_t stream = 0;  ///< of random numbers
  std::string name;          ///< for messages
};

double* FindParameter(DirectionParameters* parameters, std::string_view symbol) {
  const std::size_t n = parameters->sliders.size();
  const std::vector<std::string> symbols = ParameterSymbols(static_cast<int>(n));
  const auto place = std::ranges::find(symbols, symbol);
  if (place != symbols.end()) {
    const auto i = static_cast<std::size_t>(place - symbols.begin());
    if (i == 0) return &parameters->k;
    return i <= n ? &parameters->sliders[i - 1].k : &parameters->sliders[i - n - 1].T0;
  }
  for (EffectValues& effect : parameters->effects)
    for (auto& [name, value] : effect.parameters)
      if (symbol == effect.id + "." + name) return &value;
  return nullptr;
}

SetScatter::SetScatter(const std::array<CornerLinks, kCorners>& links, const ScatterOptions& options)
    : nominal_(links), options_(options) {
  const CornerScatter& corner = options.corner;
  if (!(corner.k >= 0 && corner.slider_k >= 0 && corner.slider_T0 >= 0))
    throw std::invalid_argument("expected relative standard deviations of corners >= 0");
  coverage_.fill(0);
  std::vector<Block> blocks;
  AddSets(&blocks);
  if (corner.Any()) AddCorners(&blocks);
  for (double& coverage : coverage_)
    if (coverage == 0) coverage = kNormalCoverage;
  const auto size = static_cast<Eigen::Index>(parameters_.size());
  centre_.resize(size);
  for (Eigen::Index i = 0; i < size; ++i) centre_[i] = parameters_[static_cast<std::size_t>(i)].value;
  covariance_ = Eigen::MatrixXd::Zero(size, size);
  values_.resize(static_cast<Eigen::Index>(options.draws), size);
  for (const Block& block : blocks) {
    const auto first = static_cast<Eigen::Index>(block.first);
    covariance_.block(first, first, block.root.rows(), block.root.rows()) = block.root * block.root.transpose();
    DrawBlock(block);
  }
}

void SetScatter::AddSets(std::vector<Block>* blocks) {
  for (std::size_t d = 0; d < kDirections.size(); ++d) {
    const Direction direction = kDirections[d];
    for (std::size_t corner = 0; corner < kCorners; ++corner) {
      DirectionParameters set = Of(nominal_[corner], direction);
      const auto same = [&](std::size_t other) { return IsSame(Of(nominal_[other], direction), set); };
      bool seen = false;
      for (std::size_t other = 0; other < corner; ++other) seen |= same(other);
      if (!set.covariance || set.covariance->order.empty() || seen) continue;
      std::array<bool, kCorners> corners{};
      for (std::size_t other = corner; other < kCorners; ++other) corners[other] = same(other);
      const Covariance& covariance = *set.covariance;
      const auto n = static_cast<Eigen::Index>(covariance.order.size());
      Block block{.first = parameters_.size(), .root = {}, .stream = 1 + d + 2 * corner, .name = Name(direction)};
      Eigen::MatrixXd C(n, n);
      for (Eigen::Index i = 0; i < n; ++i) {
        const std::string& symbol = covariance.order[static_cast<std::size_t>(i)];
        const double* value = FindParameter(&set, symbol);
        if (value == nullptr)
          throw std::invalid_argument(
              fmt::format("{} {} is in the covariance, but not in the set", Name(direction), symbol));
        parameters_.push_back({.name = fmt::format("{} {}", Name(direction), symbol),
                               .group = GroupOf(direction, symbol),
                               .symbol = symbol,
                               .direction = direction,
                               .corners = corners,
                               .value = *value,
                               .block = blocks->size()});
        SetBounds(&parameters_.back());
        for (Eigen::Index j = 0; j < n; ++j)
          C(i, j) = covariance.matrix[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
      }
      const double coverage = options_.coverage[d].value_or(covariance.coverage.value_or(kNormalCoverage));
      if (!(coverage > 0)) throw std::invalid_argument("expected a coverage > 0");
      coverage_[d] = std::max(coverage_[d], coverage);
      block.root = coverage / kNormalCoverage * CalcRoot(C, direction);
      blocks->push_back(std::move(block));
    }
  }
}

double SetScatter::FindCornerStd(const DirectionParameters& set, std::size_t i) const {
  const std::size_t sliders = set.sliders.size();
  const CornerScatter& corner = options_.corner;
  if (!corner.from_set) return i == 0 ? corner.k : i <= sliders ? corner.slider_k : corner.slider_T0;
  if (!set.covariance) return 0;
  const std::string symbol = ParameterSymbols(static_cast<int>(sliders))[i];
  const auto spread = set.covariance->spread.find(symbol);
  if (spread == set.covariance->spread.end()) return 0;
  if (!(spread->second >= 0)) throw std::invalid_argument("expected spreads >= 0");
  DirectionParameters own = set;
  const double value = *FindParameter(&own, symbol);
  return value > 0 ? spread->second / value : 0;
}

void SetScatter::AddCorners(std::vector<Block>* blocks) {
  static constexpr std::array<const char*, kCorners> kWords{"front left", "front right", "rear left", "rear right"};
  for (std::size_t d = 0; d < kDirections.size(); ++d) {
    for (std::size_t corner = 0; corner < kCorners; ++corner) {
      const std::size_t sliders = Of(nominal_[corner], kDirections[d]).sliders.size();
      const std::vector<std::string> symbols = ParameterSymbols(static_cast<int>(sliders));
      for (std::size_t i = 0; i < symbols.size(); ++i) {
        const double std = FindCornerStd(Of(nominal_[corner], kDirections[d]), i);
        if (!(std > 0)) continue;
        UncertainParameter parameter{.name = fmt::format("{} {}, {}", Name(kDirections[d]), symbols[i], kWords[corner]),
                                     .group = "corners: " + GroupOf(kDirections[d], symbols[i]),
                                     .symbol = symbols[i],
                                     .direction = kDirections[d],
                                     .corners = {},
                                     .is_factor = true,
                                     .value = 1,
                                     .low = 0,
                                     .high = kInfinite,
                                     .block = blocks->size()};
        parameter.corners[corner] = true;
        blocks->push_back({.first = parameters_.size(),
                           .root = Eigen::MatrixXd::Constant(1, 1, std),
                           .stream = 1000 + 100 * (d + 2 * corner) + i,
                           .name = parameter.name});
        parameters_.push_back(std::move(parameter));
      }
    }
  }
}

void SetScatter::DrawBlock(const Block& block) {
  Uniform uniform(options_.seed, block.stream);
  const Eigen::Index n = block.root.rows(), first = static_cast<Eigen::Index>(block.first);
  const Eigen::MatrixXd z = DrawNormal(options_.sampling, values_.rows(), n, &uniform);
  const Eigen::VectorXd m = centre_.segment(first, n);
  for (Eigen::Index draw = 0; draw < values_.rows(); ++draw) {
    Eigen::VectorXd x = m + block.root * z.row(draw).transpose();
    for (int attempt = 0;; ++attempt) {
      bool inside = true;
      for (Eigen::Index i = 0; i < n; ++i)
        inside &= IsInside(parameters_[block.first + static_cast<std::size_t>(i)], x[i]);
      if (inside) break;
      if (attempt == kMostAttempts)
        throw std::runtime_error(fmt::format(
            "of {} draws of the {} none is within the physical bounds of the parameters", kMostAttempts, block.name));
      ++redrawn_;
      x = m + block.root * DrawNormal(Sampling::kRandom, 1, n, &uniform).row(0).transpose();
    }
    values_.row(draw).segment(first, n) = x.transpose();
  }
}

std::array<CornerLinks, kCorners> SetScatter::LinksAt(const Eigen::VectorXd& values) const {
  std::array<CornerLinks, kCorners> links = nominal_;
  for (std::size_t i = 0; i < parameters_.size(); ++i) {  // the sets' own values come before the factors on them
    const UncertainParameter& parameter = parameters_[i];
    const double value = values[static_cast<Eigen::Index>(i)];
    for (std::size_t corner = 0; corner < kCorners; ++corner) {
      if (!parameter.corners[corner]) continue;
      double* const place = FindParameter(&Of(&links[corner], parameter.direction), parameter.symbol);
      *place = parameter.is_factor ? *place * value : value;
    }
  }
  return links;
}

Wagon WithLinks(const Wagon& wagon, const std::array<CornerLinks, kCorners>& links) {
  Wagon made = wagon;
  for (std::size_t corner = 0; corner < kCorners; ++corner) {
    const double load = wagon.corners[corner].load;
    const CornerLinks& set = links[corner];
    const bool springs_only = wagon.options.suspension == Suspension::kLinear;
    made.lateral[corner] = Link(springs_only ? WithoutSliders(set.lateral) : set.lateral, set.g, load);
    made.longitudinal[corner] = Link(springs_only ? WithoutSliders(set.longitudinal) : set.longitudinal, set.g, load);
    // What a wagon knows of its links as a whole is copied with it.
    if (made.lateral[corner].is_affine() != wagon.lateral[corner].is_affine() ||
        made.longitudinal[corner].is_affine() != wagon.longitudinal[corner].is_affine())
      throw std::invalid_argument("WithLinks: expected links with the same effects");
  }
  return made;
}

}  // namespace uiclink
