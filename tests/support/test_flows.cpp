#include "tests/support/test_flows.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace uiclink {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kColumns = 8;       // of the extrapolation: order 16
constexpr int kLeastSteps = 24;   // a period, so that no event is stepped over
constexpr double kFaint = 1e-12;  // of the limit of a slider: at it

/// The zero of g in (0, 1), where its sign changes (Illinois), to rounding.
double FindFraction(const std::function<double(double)>& g, double at_low, double at_high) {
  double low = 0, high = 1;
  for (int i = 0; i < 60 && high - low > 1e-15; ++i) {
    const double middle = i % 4 == 3 ? 0.5 * (low + high) : (low * at_high - high * at_low) / (at_high - at_low);
    const double value = g(middle);
    if (value == 0) return middle;
    if ((value < 0) == (at_low < 0)) {
      low = middle;
      at_low = value;
      at_high *= 0.5;
    } else {
      high = middle;
      at_high = value;
      at_low *= 0.5;
    }
  }
  return high;
}

/// A step whose error is within the tolerance; *h is the length tried, then the one taken; *next what to try then.
MatrixXd ControlledStep(const MatrixRate& rate, double t, const MatrixXd& z, const VectorXd& scales, double tolerance,
                        double* h, double* next) {
  for (int tries = 0; tries < 60; ++tries) {
    VectorXd error;
    MatrixXd after = ExtrapolatedStep(rate, t, z, *h, &error);
    const double size = error.cwiseQuotient(scales).cwiseAbs().maxCoeff() / tolerance;
    const double factor = 0.8 * std::pow(std::max(size, 1e-10), -1.0 / (2 * kColumns - 1));
    *next = *h * std::clamp(std::isfinite(factor) ? factor : 0.1, 0.1, 3.0);
    if (size <= 1 && after.allFinite()) return after;
    *h = *next;
  }
  throw std::runtime_error("the step of the integration became too short");
}

}  // namespace

MatrixXd ExtrapolatedStep(const MatrixRate& rate, double t, const MatrixXd& z, double h, VectorXd* error) {
  const MatrixXd first = rate(t, z);
  std::vector<MatrixXd> row, above;  // of the table of Aitken and Neville, in squares of the step
  for (int j = 0; j < kColumns; ++j) {
    const int n = 2 * (j + 1);
    const double step = h / n;
    MatrixXd before = z, now = z + step * first;
    for (int i = 1; i < n; ++i) {
      MatrixXd after = before + 2 * step * rate(t + i * step, now);
      before = std::move(now);
      now = std::move(after);
    }
    row = {now};
    for (std::size_t k = 1; k <= static_cast<std::size_t>(j); ++k) {
      const double ratio = double(n) / double(n - 2 * static_cast<int>(k));
      row.push_back(row[k - 1] + (row[k - 1] - above[k - 1]) / (ratio * ratio - 1));
    }
    above = row;
  }
  if (error != nullptr) *error = (row[kColumns - 1] - row[kColumns - 2]).col(0);
  return row.back();
}

SmoothFlow::SmoothFlow(Model model) : model_(std::move(model)) {
  for (const int i : model_.watched) names_.push_back("z" + std::to_string(i));
}

std::optional<double> SmoothFlow::ForcedPeriod(double lambda) const {
  if (!model_.forced_period) return std::nullopt;
  return model_.forced_period(lambda).first;
}

void SmoothFlow::Watch(const MatrixRate& rate, double t, double h, const MatrixXd& before, const MatrixXd& after,
                       Passage* passage) const {
  const VectorXd start = before.col(0), rate_before = rate(t, start), rate_after = rate(t + h, after.col(0));
  for (std::size_t w = 0; w < model_.watched.size(); ++w) {
    const int i = model_.watched[w];
    const auto k = static_cast<Eigen::Index>(w);
    double value = after(i, 0);
    if (rate_before[i] * rate_after[i] < 0) {
      const auto rate_at = [&](double part) {
        return rate(t + part * h, ExtrapolatedStep(rate, t, start, part * h))(i, 0);
      };
      value = ExtrapolatedStep(rate, t, start, h * FindFraction(rate_at, rate_before[i], rate_after[i]))(i, 0);
    }
    passage->least[k] = std::min({passage->least[k], value, after(i, 0)});
    passage->greatest[k] = std::max({passage->greatest[k], value, after(i, 0)});
  }
}

/// Part of a step to the first kink; one without.
double SmoothFlow::FirstKink(const MatrixRate& rate, double t, double h, const MatrixXd& before,
                             const MatrixXd& after) const {
  double first = 1;
  if (!model_.kinks) return first;
  const VectorXd start = before.col(0), kinks_before = model_.kinks(start), kinks_after = model_.kinks(after.col(0));
  for (Eigen::Index i = 0; i < kinks_before.size(); ++i) {
    // A step that began at a kink has left it.
    if (kinks_before[i] * kinks_after[i] >= 0 || std::abs(kinks_before[i]) < kFaint * std::abs(kinks_after[i]))
      continue;
    const auto at = [&](double part) { return model_.kinks(ExtrapolatedStep(rate, t, start, part * h))[i]; };
    first = std::min(first, FindFraction(at, kinks_before[i], kinks_after[i]));
  }
  return first;
}

Passage SmoothFlow::Pass(const VectorXd& start, double T, double lambda, Derivatives wanted) {
  const Eigen::Index n = size();
  const MatrixRate rate = [&](double t, const MatrixXd& z) {
    MatrixXd out(z.rows(), z.cols());
    out.col(0) = model_.rate(t, z.col(0), lambda);
    if (z.cols() > 1) {
      const MatrixXd jacobian = model_.jacobian(t, z.col(0), lambda);
      out.rightCols(n + 1) = jacobian.leftCols(n) * z.rightCols(n + 1);
      out.col(n + 1) += jacobian.col(n);
    }
    return out;
  };
  MatrixXd z = start;
  if (wanted == Derivatives::kAll) {
    z.setZero(n, n + 2);
    z.col(0) = start;
    z.middleCols(1, n).setIdentity();
  }
  Passage passage;
  passage.least = passage.greatest = start(model_.watched);
  double t = 0, h = T / kLeastSteps, next = 0;
  while (T - t > 1e-14 * T) {
    h = std::min({h, T / kLeastSteps, T - t});
    MatrixXd after = ControlledStep(rate, t, z, model_.scales, model_.tolerance, &h, &next);
    if (const double part = FirstKink(rate, t, h, z, after); part < 1) {
      h *= part;
      after = ExtrapolatedStep(rate, t, z, h);
    }
    Watch(rate, t, h, z, after, &passage);
    z = std::move(after);
    t += h;
    h = next;
  }
  passage.end = z.col(0);
  passage.rate = model_.rate(T, passage.end, lambda);
  if (wanted == Derivatives::kAll) {
    passage.by_start = z.middleCols(1, n);
    passage.by_parameter = z.col(n + 1);
    if (model_.forced_period) passage.by_parameter += passage.rate * model_.forced_period(lambda).second;
  }
  return passage;
}

SliderFlow::SliderFlow(const SliderOscillator& oscillator) : oscillator_(oscillator) {}

std::optional<double> SliderFlow::ForcedPeriod(double lambda) const { return 2 * std::numbers::pi / lambda; }

void SliderFlow::Follow(const VectorXd& from, const std::vector<int>& slaved, VectorXd* state) const {
  if (!slaved.empty()) (*state)[2] += (*state)[0] - from[0];
}

namespace {

/// One period of the oscillator, from event to event.
class SliderRun {
 public:
  SliderRun(const SliderOscillator& oscillator, const VectorXd& start, double lambda, bool derivatives)
      : o_(oscillator), lambda_(lambda), limit_(oscillator.T0 / oscillator.k1) {
    z_ = start;
    if (derivatives) {
      z_.setZero(3, 5);
      z_.col(0) = start;
      z_.middleCols(1, 3).setIdentity();
    }
    const double stretch = start[0] - start[2];
    if (std::abs(stretch) >= limit_ * (1 - kFaint)) {
      slaved_start_ = true;
      Slide(stretch > 0 ? 1 : -1);
      if (start[1] * sliding_ <= 0) sliding_ = 0;
    }
    least_ = greatest_ = start[0];
  }

  Passage Run(double T) {
    const MatrixRate rate = [this](double t, const MatrixXd& z) { return Rate(t, z); };
    double t = 0, h = T / kLeastSteps, next = 0;
    while (T - t > 1e-14 * T) {
      h = std::min({h, T / kLeastSteps, T - t});
      MatrixXd after = ControlledStep(rate, t, z_, VectorXd::Ones(3), 1e-14, &h, &next);
      const double g_before = Guard(z_.col(0)), g_after = Guard(after.col(0));
      const bool event = g_before < 0 && g_after >= 0;
      if (event) {
        h *= FindFraction([&](double part) { return Guard(ExtrapolatedStep(rate, t, z_.leftCols(1), part * h)); },
                          g_before, g_after);
        after = ExtrapolatedStep(rate, t, z_, h);
      }
      Watch(rate, t, h, after);
      z_ = std::move(after);
      t += h;
      h = next;
      if (event && sliding_ != 0) {
        sliding_ = 0;
      } else if (event) {
        Slide(z_(0, 0) > z_(2, 0) ? 1 : -1);
      }
    }
    return Collect(T);
  }

 private:
  /// Below zero while nothing happens: sliding, against the speed; sticking, up to the limit.
  double Guard(const VectorXd& z) const { return sliding_ != 0 ? -sliding_ * z[1] : std::abs(z[0] - z[2]) - limit_; }

  /// From here on p follows x: its own freedom is gone. The rates of x and x' do not jump.
  void Slide(int direction) {
    sliding_ = direction;
    ++slides_;
    z_.row(2) = z_.row(0);
    z_(2, 0) -= direction * limit_;
  }

  MatrixXd Rate(double t, const MatrixXd& z) const {
    MatrixXd rate(3, z.cols());
    const double x = z(0, 0), phase = lambda_ * t;
    rate.row(0) = z.row(1);
    rate.row(1) = -2 * o_.zeta * z.row(1) - (o_.k0 + o_.k1) * z.row(0) + o_.k1 * z.row(2);
    if (z.cols() > 1) {
      rate.row(1).tail(4) -= 3 * o_.k3 * x * x * z.row(0).tail(4);
      rate(1, 4) -= o_.force * t * std::sin(phase);
    }
    rate(1, 0) += o_.force * std::cos(phase) - o_.k3 * x * x * x;
    rate.row(2) = (sliding_ != 0 ? 1.0 : 0.0) * z.row(1);
    return rate;
  }

  void Watch(const MatrixRate& rate, double t, double h, const MatrixXd& after) {
    double value = after(0, 0);
    if (z_(1, 0) * after(1, 0) < 0) {
      const MatrixXd start = z_.leftCols(1);
      const auto speed = [&](double part) { return ExtrapolatedStep(rate, t, start, part * h)(1, 0); };
      value = ExtrapolatedStep(rate, t, start, h * FindFraction(speed, z_(1, 0), after(1, 0)))(0, 0);
    }
    least_ = std::min({least_, value, after(0, 0)});
    greatest_ = std::max({greatest_, value, after(0, 0)});
  }

  Passage Collect(double T) const {
    Passage passage;
    passage.end = z_.col(0);
    passage.rate = Rate(T, z_.leftCols(1));
    if (slaved_start_) passage.slaved_start = {2};
    if (sliding_ != 0) passage.slaved_end = {2};
    if (slides_ == 0) passage.held = {2};
    passage.least = VectorXd::Constant(1, least_);
    passage.greatest = VectorXd::Constant(1, greatest_);
    passage.character = slides_ == 0 ? "sticks" : "slides";
    if (z_.cols() > 1) {
      passage.by_start = z_.middleCols(1, 3);
      if (slaved_start_) passage.by_start.col(2).setZero();
      passage.by_parameter = z_.col(4) - passage.rate * (T / lambda_);
    }
    return passage;
  }

  const SliderOscillator& o_;
  double lambda_, limit_;
  MatrixXd z_;  ///< the state, its derivatives by the start and by the frequency
  int sliding_ = 0, slides_ = 0;
  bool slaved_start_ = false;
  double least_ = 0, greatest_ = 0;
};

}  // namespace

Passage SliderFlow::Pass(const VectorXd& start, double T, double lambda, Derivatives wanted) {
  return SliderRun(oscillator_, start, lambda, wanted == Derivatives::kAll).Run(T);
}

}  // namespace uiclink
