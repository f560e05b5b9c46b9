#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <random>
#include <string_view>
#include <utility>
#include <vector>

#include "identify/extended_fit.h"

namespace uiclink {

/// Records that an extended model itself has made, with all unknowns known. Not to be copied: the data point into it.
struct SyntheticRecords {
  Extension extension;
  ExtendedState truth;
  Sharing sharing = Sharing::kLink;
  std::deque<Record> records;
  std::vector<FitData> data;

  SyntheticRecords() = default;
  SyntheticRecords(SyntheticRecords&&) = default;
  SyntheticRecords& operator=(SyntheticRecords&&) = default;
};

/// How they are read.
struct Reading {
  double sampling_hz = 200;
  double seconds = 9;
  double sigma = 1.3e-5;   ///< stated noise of the readings [m]
  double noise = 0;        ///< true noise [m]
  bool irregular = false;  ///< time stamps off the grid by up to a third of a step
};

/// Links of `sliders` joints whose critical displacements differ by more than a factor of two: 8.1 mm; 2, 6 mm; ...
inline Oscillator<double> MakeLink(int sliders) {
  Oscillator<double> link;
  link.k = sliders == 1 ? 3.41 : 5.5;
  const double k[] = {2.0, 0.9, 0.7, 0.6}, y_c[] = {2e-3, 6e-3, 11e-3, 0.9e-3};
  if (sliders == 1) link.Add({.k = 2.21, .T0 = 0.018});
  for (int i = 0; sliders > 1 && i < sliders; ++i) link.Add({.k = k[i], .T0 = k[i] * y_c[i]});
  return link;
}

/// Values of an effect that show clearly in records with a swing of some 25 mm, in coordinates of the fit.
/// The first two records' own values differ.
inline std::vector<double> MakeCoordinates(const Effect& effect, double share, std::size_t record = 0) {
  constexpr double kSwing = 0.025, kSpeed = 0.15;
  std::vector<double> x;
  for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
    const EffectParameter& p = effect.parameters[i];
    double value = p.starts.empty() ? 17.3 : p.starts.front();
    if (p.start_scale == StartScale::kSwing) value *= kSwing;
    if (p.start_scale == StartScale::kSpeed) value *= kSpeed;
    if (p.start_scale == StartScale::kSpectrum && p.high < 10) value = 1.37;  // off the link's own 0.9 to 1.2 Hz
    if (effect.quadrature && i == 1) value = 0.6 * effect.parameters[0].starts.front();
    const bool level = std::isinf(effect.neutral) && p.coordinate == Coordinate::kLinear;
    const bool is_size = i == 0 || (effect.quadrature && i == 1);
    double coordinate = ToCoordinate(p, value);
    if (is_size) coordinate = level ? coordinate / share : coordinate * share;
    if (p.scope == Scope::kRecord && record % 2 == 1) coordinate *= -0.7;
    x.push_back(coordinate);
  }
  return x;
}

/// Fills a record with what its model gives, and noise.
inline void ReadModel(const Reading& reading, std::size_t r, std::mt19937_64* random, SyntheticRecords* made) {
  Record& record = made->records[r];
  std::fill(record.y.begin(), record.y.end(), 0.0);
  const std::vector<double> y = CalcExtendedResiduals(made->data[r], made->extension, made->truth, r);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < y.size(); ++i) record.y[made->data[r].first + i] = y[i] + reading.noise * normal(*random);
}

struct SyntheticOptions {
  int sliders = 1;
  Sharing sharing = Sharing::kLink;
  double scatter = 0;  ///< of the levels from record to record, with Sharing::kShape [-]
  double share = 1;    ///< of the effects' sizes
  unsigned seed = 1;
};

/// One record for each reading: starts at +-25 mm, a little different, from a zero that is off.
inline SyntheticRecords MakeSynthetic(const std::vector<const Effect*>& effects, const std::vector<Reading>& readings,
                                      const SyntheticOptions& options = {}) {
  SyntheticRecords made;
  made.extension = Extension(effects);
  made.sharing = options.sharing;
  std::mt19937_64 random(options.seed);
  std::normal_distribution<double> normal;
  Levels levels;
  FromOscillator(MakeLink(options.sliders), &levels, &made.truth.link.shape);
  made.truth.shared.resize(made.extension.shared().size());
  made.truth.own.resize(readings.size());
  for (std::size_t r = 0; r < readings.size(); ++r) {
    const Reading& reading = readings[r];
    Record record;
    record.sampling_hz = reading.sampling_hz;
    record.uniform = !reading.irregular;
    const auto size = static_cast<std::size_t>(reading.seconds * reading.sampling_hz);
    for (std::size_t i = 0; i < size; ++i)
      record.t.push_back(
          (static_cast<double>(i) + (reading.irregular ? std::sin(1.7 * static_cast<double>(i)) / 3 : 0)) /
          reading.sampling_hz);
    record.y.resize(size);
    made.records.push_back(record);
    const double side = r % 2 == 0 ? 1 : -1, zero = 2e-4 * std::cos(static_cast<double>(r));
    const auto first = static_cast<std::size_t>(0.1 * reading.sampling_hz);
    made.truth.link.starts.push_back(
        {side * (0.025 + 7e-4 * static_cast<double>(r)), made.records[r].t[first] - 0.0013, zero});
    made.data.push_back({.record = &made.records[r],
                         .first = first,
                         .size = size - first,
                         .sigma = reading.sigma,
                         .centre = zero,
                         .swing = 0.025 + 7e-4 * static_cast<double>(r),
                         .smallest = 1e-4});
    if (options.sharing == Sharing::kShape || r == 0) {
      made.truth.link.levels.push_back(levels);
      for (double& level : made.truth.link.levels.back()) level += options.scatter * normal(random);
    }
    made.truth.own[r].resize(made.extension.own().size());
  }
  for (const Effect* effect : effects)
    for (std::size_t r = 0; r < readings.size(); ++r) {
      const std::vector<double> x = MakeCoordinates(*effect, options.share, r);
      for (std::size_t i = 0; i < made.extension.shared().size(); ++i)
        if (made.extension.shared()[i].effect == effect)
          made.truth.shared[i] = MakeCoordinates(*effect, options.share)[made.extension.shared()[i].parameter];
      for (std::size_t i = 0; i < made.extension.own().size(); ++i)
        if (made.extension.own()[i].effect == effect) made.truth.own[r][i] = x[made.extension.own()[i].parameter];
    }
  for (std::size_t r = 0; r < readings.size(); ++r) ReadModel(readings[r], r, &random, &made);
  return made;
}

}  // namespace uiclink
