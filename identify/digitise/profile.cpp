#include "identify/digitise/profile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace uiclink::digitise {
namespace {

double Phi(double z) { return 0.5 * std::erfc(-z * std::numbers::sqrt2 / 2); }
double Density(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2 * std::numbers::pi); }

/// Tables of both, steps of 1/64: linear interpolation errs by 3e-5.
class Tables {
 public:
  Tables() {
    for (int i = 0; i < kSize; ++i) {
      phi_[std::size_t(i)] = Phi((i - kSize / 2) / kSteps);
      density_[std::size_t(i)] = Density((i - kSize / 2) / kSteps);
    }
  }
  double phi(double z) const { return Look(phi_, z); }
  double density(double z) const { return Look(density_, z); }

 private:
  static constexpr double kSteps = 64;
  static constexpr int kSize = 64 * 10 + 1;

  static double Look(const std::array<double, kSize>& table, double z) {
    const double place = std::clamp(z * kSteps + kSize / 2, 0.0, kSize - 1.001);
    const auto i = static_cast<std::size_t>(place);
    const double part = place - static_cast<double>(i);
    return table[i] + part * (table[i + 1] - table[i]);
  }
  std::array<double, kSize> phi_, density_;
};

const Tables& Table() {
  static const Tables tables;
  return tables;
}

}  // namespace

Shade ShadeOf(const Profile& profile, double s1) {
  const double h = 0.5 * profile.width, s = profile.blur, a = profile.amplitude;
  const Tables& t = Table();
  return {a * (t.phi((s1 + h) / s) - t.phi((s1 - h) / s)), a / s * (t.density((s1 + h) / s) - t.density((s1 - h) / s)),
          0};
}

Shade ShadeOf(const Profile& profile, double s1, double s2) {
  const double h = 0.5 * profile.width;
  const Shade first = ShadeOf(profile, s1);
  if (std::abs(s1 - s2) >= 2 * h) {
    const Shade second = ShadeOf(profile, s2);
    return {first.share + second.share, first.by_first, second.by_first};
  }
  const double s = profile.blur, a = profile.amplitude;
  const Tables& t = Table();
  const bool first_is_higher = s1 > s2;
  const double high = std::max(s1, s2) + h, low = std::min(s1, s2) - h;
  const double by_high = a / s * t.density(high / s), by_low = -a / s * t.density(low / s);
  return {a * (t.phi(high / s) - t.phi(low / s)), first_is_higher ? by_high : by_low,
          first_is_higher ? by_low : by_high};
}

Profile FitProfile(const std::vector<std::pair<float, float>>& samples, const Profile& start) {
  constexpr double kBin = 0.1;
  std::vector<std::vector<float>> bins(200);
  for (const auto& [distance, share] : samples) {
    const auto bin = static_cast<std::size_t>(std::abs(distance) / kBin);
    if (bin < bins.size()) bins[bin].push_back(share);
  }
  struct Point {
    double d, share, weight;
  };
  std::vector<Point> points;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    std::vector<float>& bin = bins[i];
    if (bin.size() < 5) continue;
    const auto middle = bin.begin() + static_cast<std::ptrdiff_t>(bin.size() / 2);
    std::nth_element(bin.begin(), middle, bin.end());
    points.push_back({(double(i) + 0.5) * kBin, *middle, std::sqrt(double(bin.size()))});
  }
  if (points.size() < 8) return start;
  Profile best = start;
  double least = 1e300;
  for (double blur = 0.28; blur < 6; blur *= 1.08) {
    for (double width = 0.6; width < 20; width *= 1.05) {
      Profile profile{1, width, blur};
      double mm = 0, ms = 0, ss = 0;
      for (const Point& p : points) {
        const double m = ShadeOf(profile, p.d).share;
        mm += p.weight * m * m, ms += p.weight * m * p.share, ss += p.weight * p.share * p.share;
      }
      profile.amplitude = std::clamp(ms / std::max(mm, 1e-12), 0.6, 1.6);
      const double a = profile.amplitude;
      const double off = ss - 2 * a * ms + a * a * mm;
      if (off < least) least = off, best = profile;
    }
  }
  return best;
}

}  // namespace uiclink::digitise
