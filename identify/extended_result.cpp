#include "identify/extended_result.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/noise.h"
#include "identify/screen.h"

namespace uiclink {
namespace {

constexpr double kWhitenessLevel = 1e-4;  // residuals count as structured below this p-value,
constexpr double kRmsLevel = 1.04;        // or from this rms in noise levels on: three deviations for three records
constexpr double kSwallowed = 0.9;  // a noise estimate above the residuals' own by this share had swallowed a tone

double NormalBound() { return CalcStudentBound(0.95, std::numeric_limits<double>::infinity()); }

/// Noise floor of a record, given what a model leaves: what was taken for noise may have been a tone.
double EstimateFloor(const FitData& data, std::span<const double> residuals) {
  const std::vector<double>& t = data.record->t;
  const auto begin = t.begin() + static_cast<std::ptrdiff_t>(data.first);
  const std::vector<double> times(begin, begin + static_cast<std::ptrdiff_t>(data.size));
  std::span<const double> stated = data.record->uncertainty;
  if (!stated.empty()) stated = stated.subspan(data.first, data.size);
  const double floor = EstimateNoise(times, residuals, stated).sigma;
  return floor < kSwallowed * data.sigma ? floor : data.sigma;
}

}  // namespace

Structure CalcStructure(std::span<const FitData> data, const Extension& extension, const ExtendedState& state) {
  Structure structure;
  double squares = 0, noise = 0, samples = 0;
  for (std::size_t r = 0; r < data.size(); ++r) {
    const std::vector<double> residuals = CalcExtendedResiduals(data[r], extension, state, r);
    double sum = residuals.empty() ? std::numeric_limits<double>::infinity() : 0;
    for (const double x : residuals) sum += x * x;
    const auto n = static_cast<double>(data[r].size);
    const double floor =
        !extension.readings().empty() && std::isfinite(sum) ? EstimateFloor(data[r], residuals) : data[r].sigma;
    structure.rms_of_record.push_back(std::sqrt(sum / n));
    structure.noise_of_record.push_back(floor);
    squares += sum;
    noise += n * floor * floor;
    samples += n;
    if (!std::isfinite(sum)) continue;
    const Whiteness whiteness = TestWhiteness(residuals);
    structure.whiteness_p = std::min(structure.whiteness_p, whiteness.p_value * static_cast<double>(data.size()));
    structure.effective_size += whiteness.p_value < 1e-3 ? CalcEffectiveSize(residuals) : n;
  }
  structure.rms = std::sqrt(squares / samples);
  structure.noise = std::sqrt(noise / samples);
  structure.structured = structure.whiteness_p < kWhitenessLevel || structure.rms > kRmsLevel * structure.noise;
  return structure;
}

namespace {

/// The description of an extended fit in the making.
class Describer {
 public:
  Describer(std::span<const FitData> data, ExtendedResult* result)
      : data_(data),
        result_(*result),
        state_(result->outcome.state),
        sliders_(CountSliders(state_.link.shape)),
        map_(result->extension, result->sharing, sliders_, data.size(), !state_.link.shapes.empty()) {}

  void Run() {
    result_.structure = CalcStructure(data_, result_.extension, state_);
    const Structure& s = result_.structure;
    const double ratio = s.rms / s.noise;
    double samples = 0;
    for (const FitData& d : data_) samples += static_cast<double>(d.size);
    // In units of data.sigma, which may hold a tone that is no noise any more.
    double sigma = 0;
    for (const FitData& d : data_) sigma += d.sigma * d.sigma * static_cast<double>(d.size) / samples;
    const double noise = s.noise * s.noise / sigma;
    factor_ = noise * ratio * ratio * (s.structured ? std::max(1.0, samples / std::max(1.0, s.effective_size)) : 1.0);
    result_.variance_factor = factor_;
    normal_ = CalcNormal(data_, result_.sharing, result_.extension, state_, 1);
    all_ = InvertScaled(normal_.gram);
    result_.sharing == Sharing::kLink ? DescribeShared() : DescribeOwn();
    DescribeEffects();
  }

 private:
  Eigen::MatrixXd InvertScaled(const Eigen::MatrixXd& gram) const { return factor_ * InvertDetermined(gram, 1e-12); }

  /// Numbers of the coordinates (levels, shape) of one record's link among all unknowns.
  std::vector<Eigen::Index> LinkColumns(std::size_t record) const {
    std::vector<Eigen::Index> columns = map_.Columns(record);
    columns.resize(static_cast<std::size_t>(2 * sliders_ + 1));
    return columns;
  }

  void DescribeShared() {
    result_.link = ToOscillator(state_.link.levels[0], state_.link.shape, data_[0].g);
    const std::vector<Eigen::Index> columns = LinkColumns(0);
    Eigen::MatrixXd covariance = all_(columns, columns);
    for (Eigen::Index i = 0; i < covariance.rows(); ++i) covariance(i, i) = std::max(covariance(i, i), 1e-16);
    for (int q = 0; q < CountQuantities(sliders_); ++q) {
      const double std = std::min(kUndetermined, CalcLogStd(result_.link, covariance, q));
      AddQuantity(CalcQuantity(result_.link, q), std, NormalBound() * std, 0);
    }
  }

  void AddQuantity(double value, double log_std, double log_half_width, double log_spread) {
    const bool open = !(log_half_width < kUndetermined);
    log_half_width = std::min(log_half_width, kUndetermined);
    result_.quantities.push_back({.value = value,
                                  .std = value * std::min(log_std, kUndetermined),
                                  .low = value * std::exp(-log_half_width),
                                  .high = value * std::exp(log_half_width),
                                  .low_open = open,
                                  .high_open = open,
                                  .spread = value * log_spread});
  }

  void DescribeOwn() {
    const std::size_t records = data_.size();
    Levels mean{};
    for (const Levels& levels : state_.link.levels)
      for (std::size_t j = 0; j < mean.size(); ++j) mean[j] += levels[j] / static_cast<double>(records);
    // Given the effects, the links of the records are independent of each other.
    std::vector<Eigen::Index> without;
    const Eigen::Index first_shared = map_.first_shared();
    const auto shared = static_cast<Eigen::Index>(result_.extension.shared().size());
    for (Eigen::Index i = 0; i < map_.size(); ++i)
      if (i < first_shared || i >= first_shared + shared) without.push_back(i);
    const Eigen::MatrixXd given_part = InvertScaled(normal_.gram(without, without));
    Eigen::MatrixXd given = Eigen::MatrixXd::Zero(map_.size(), map_.size());
    given(without, without) = given_part;

    const int quantities = CountQuantities(sliders_);
    for (int q = 0; q < quantities; ++q) {
      std::vector<double> values, errors;
      Eigen::VectorXd weights = Eigen::VectorXd::Zero(map_.size());
      for (std::size_t r = 0; r < records; ++r) {
        const Oscillator<double> link = ToOscillator(state_.link.LevelsOf(r), state_.link.ShapeOf(r), data_[r].g);
        const Eigen::RowVectorXd gradient = CalcLogGradient(link, q);
        const std::vector<Eigen::Index> columns = LinkColumns(r);
        for (std::size_t i = 0; i < columns.size(); ++i)
          weights(columns[i]) += gradient(static_cast<Eigen::Index>(i)) / static_cast<double>(records);
        const Eigen::MatrixXd block = given(columns, columns);
        values.push_back(std::log(CalcQuantity(link, q)));
        errors.push_back(std::sqrt(std::max(1e-16, (gradient * block * gradient.transpose())(0, 0))));
      }
      const Population population = EstimatePopulation(values, errors);
      const double common = std::max(0.0, weights.dot((all_ - given) * weights));
      const double std = std::hypot(population.std, std::sqrt(common));
      const double half = std::hypot(population.half_width, NormalBound() * std::sqrt(common));
      AddQuantity(std::exp(population.mean), std, half, population.spread);
    }
    Shape shape = state_.link.shape;
    for (std::size_t j = 0; j < shape.size() && !state_.link.shapes.empty(); ++j) {
      shape[j] = 0;
      for (const Shape& own : state_.link.shapes) shape[j] += own[j] / static_cast<double>(records);
    }
    result_.link = ToOscillator(mean, shape, data_[0].g);
  }

  void DescribeEffects() {
    for (const Effect* effect : result_.extension.effects()) {
      DescribeSharedOf(effect);
      DescribeOwnOf(effect);
    }
  }

  void DescribeSharedOf(const Effect* effect) {
    const std::span<const Extension::Unknown> unknowns = result_.extension.shared();
    const std::vector<Eigen::Index> columns = map_.Columns(0);
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      if (unknowns[i].effect != effect) continue;
      const Eigen::Index column = columns[static_cast<std::size_t>(2 * sliders_ + 1 + 3) + i];
      const EffectParameter& parameter = unknowns[i].Parameter();
      const double x = state_.shared[i], std = std::sqrt(std::max(0.0, all_(column, column)));
      const double low = std::clamp(x - NormalBound() * std, unknowns[i].low, unknowns[i].high);
      const double high = std::clamp(x + NormalBound() * std, unknowns[i].low, unknowns[i].high);
      EffectEstimate estimate;
      estimate.effect = effect;
      estimate.symbol = parameter.symbol;
      estimate.unit = parameter.unit;
      estimate.meaning = parameter.meaning;
      estimate.value = FromCoordinate(parameter, x);
      estimate.low = FromCoordinate(parameter, low);
      estimate.high = FromCoordinate(parameter, high);
      if (estimate.low > estimate.high) std::swap(estimate.low, estimate.high);
      estimate.std = std * std::abs(CalcSlope(parameter, x));
      estimate.at_bound = unknowns[i].IsAtBound(x);
      result_.effects.push_back(estimate);
    }
  }

  void DescribeOwnOf(const Effect* effect) {
    const std::span<const Extension::Unknown> unknowns = result_.extension.own();
    const std::size_t link = static_cast<std::size_t>(2 * sliders_ + 1 + 3) + result_.extension.shared().size();
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      if (unknowns[i].effect != effect) continue;
      if (effect->quadrature && unknowns[i].parameter == 1) continue;  // told with parameter 0
      std::vector<double> values, errors;
      for (std::size_t r = 0; r < data_.size(); ++r) {
        const std::vector<Eigen::Index> columns = map_.Columns(r);
        const Eigen::Index column = columns[link + i];
        const double x = state_.own[r][i];
        double value = x, variance = all_(column, column);
        if (effect->quadrature && unknowns[i].parameter == 0) {
          const double y = state_.own[r][i + 1];
          value = std::hypot(x, y);
          const Eigen::Index other = columns[link + i + 1];
          if (value > 0)
            variance = (x * x * all_(column, column) + 2 * x * y * all_(column, other) + y * y * all_(other, other)) /
                       (value * value);
        }
        values.push_back(value);
        errors.push_back(std::sqrt(std::max(1e-300, variance)));
      }
      const Population population = EstimatePopulation(values, errors);
      EffectEstimate estimate;
      estimate.effect = effect;
      estimate.symbol = effect->quadrature && unknowns[i].parameter == 0 ? "A" : unknowns[i].Parameter().symbol;
      estimate.unit = unknowns[i].Parameter().unit;
      estimate.meaning = estimate.symbol == "A" ? "amplitude where the fit begins" : unknowns[i].Parameter().meaning;
      estimate.value = population.mean;
      estimate.std = population.std;
      estimate.low = population.mean - population.half_width;
      estimate.high = population.mean + population.half_width;
      estimate.spread = population.spread;
      result_.effects.push_back(estimate);
    }
  }

  std::span<const FitData> data_;
  ExtendedResult& result_;
  const ExtendedState& state_;
  int sliders_;
  UnknownMap map_;
  double factor_ = 1;
  Normal normal_;
  Eigen::MatrixXd all_;
};

}  // namespace

ExtendedResult Describe(std::span<const FitData> data, Sharing sharing, const Extension& extension,
                        const ExtendedOutcome& outcome) {
  ExtendedResult result;
  result.extension = extension;
  result.sharing = sharing;
  result.outcome = outcome;
  Describer(data, &result).Run();
  return result;
}

}  // namespace uiclink
