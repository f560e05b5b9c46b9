#include "identify/extended_columns.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "identify/link_coordinates.h"

namespace uiclink {

ExtendedColumns::ExtendedColumns(const Extension& extension, int sliders)
    : extension_(extension),
      sliders_(sliders),
      link_(2 * sliders + 1),
      unknowns_(link_ + 3 + static_cast<int>(extension.shared().size() + extension.own().size())) {}

bool ExtendedColumns::Evaluate(const FitData& data, std::size_t size, std::size_t stride, const double* levels,
                               const double* shape, const double* start, const double* shared, const double* own,
                               bool derivatives) {
  ++evaluations_;
  const std::vector<double>& t = data.record->t;
  size_ = (size + stride - 1) / stride;
  columns_.resize(size_ * static_cast<std::size_t>(unknowns_ + 1));
  clock_.resize(size_);
  for (std::size_t i = 0; i < size_; ++i) clock_[i] = t[data.first + i * stride];
  fit_start_ = t[data.first];
  SampleTimes times{
      .first = clock_[0] - start[1], .step = static_cast<double>(stride) / data.record->sampling_hz, .size = size_};
  if (!data.record->uniform) {
    times_.resize(size_);
    for (std::size_t i = 0; i < size_; ++i) times_[i] = clock_[i] - start[1];
    times.times = times_;
  }
  const int duals = link_ + 1 + extension_.CountMechanical();
  bool solved = false;
  if (!derivatives) {
    solved = EvaluatePlain(data, times, levels, shape, start, shared);
  } else if (duals <= 6) {
    solved = EvaluateDual<6>(data, times, levels, shape, start, shared);
  } else if (duals <= 8) {
    solved = EvaluateDual<8>(data, times, levels, shape, start, shared);
  } else if (duals <= 12) {
    solved = EvaluateDual<12>(data, times, levels, shape, start, shared);
  } else {
    assert(duals <= 16);
    solved = EvaluateDual<16>(data, times, levels, shape, start, shared);
  }
  if (!solved) return false;
  Read(data, stride, start, {shared, extension_.shared().size()}, {own, extension_.own().size()}, derivatives);
  return true;
}

bool ExtendedColumns::EvaluatePlain(const FitData& data, const SampleTimes& times, const double* levels,
                                    const double* shape, const double* start, const double* shared) {
  ExtendedOscillator<double> oscillator = Extend(ToOscillator(levels, shape, sliders_, data.g));
  for (const Effect* effect : extension_.effects()) {
    if (!effect->IsMechanical()) continue;
    effect->Extend<double>(extension_.CalcLawValues(effect, {shared, extension_.shared().size()}, {}), &oscillator);
  }
  const double duration = std::max(0.0, times[size_ - 1]);
  if (Solve(oscillator, start[0], fit_start_, duration, &plain_, {.tolerance = tolerance_}) != SolveStatus::kOk)
    return false;
  CalcDisplacements(plain_, times, {Column(unknowns_), size_});
  return true;
}

template <int N>
bool ExtendedColumns::EvaluateDual(const FitData& data, const SampleTimes& times, const double* levels,
                                   const double* shape, const double* start, const double* shared) {
  using T = Dual<N>;
  ExtendedOscillator<T> oscillator = Extend(ToOscillator<T>(levels, shape, sliders_, data.g));
  int next = link_ + 1;
  std::array<int, static_cast<std::size_t>(N)> unknown_of{};  // which shared unknown a dual belongs to
  for (const Effect* effect : extension_.effects()) {
    if (!effect->IsMechanical()) continue;
    std::array<T, kMaxLawParameters> p;
    for (std::size_t i = 0; i < extension_.shared().size(); ++i) {
      const Extension::Unknown& unknown = extension_.shared()[i];
      if (unknown.effect != effect) continue;
      const bool log = unknown.Parameter().coordinate == Coordinate::kLog;
      T value(log ? std::exp(shared[i]) : shared[i]);
      value.v(next) = log ? value.a : 1.0;
      unknown_of[static_cast<std::size_t>(next)] = static_cast<int>(i);
      p[unknown.parameter] = value;
      ++next;
    }
    effect->Extend<T>({p.data(), effect->parameters.size()}, &oscillator);
  }
  auto& trajectory = std::get<ExtendedTrajectory<T>>(duals_);
  const double duration = std::max(0.0, times[size_ - 1]);
  const T y0(start[0], link_);
  if (Solve(oscillator, y0, fit_start_, duration, &trajectory, {.tolerance = tolerance_}) != SolveStatus::kOk)
    return false;
  // Into the columns of link, y0, t0, and of as many shared unknowns; these are then put where they belong.
  const int mechanical = next - link_ - 1;
  scratch_.resize(size_ * static_cast<std::size_t>(mechanical + link_ + 1));
  CalcDisplacements(trajectory, times, link_ + 1 + mechanical, {Column(unknowns_), size_}, {Column(link_ + 1), size_},
                    scratch_);
  std::copy_n(scratch_.begin(), size_ * static_cast<std::size_t>(link_ + 1), columns_.begin());
  double* by_t0 = Column(link_ + 1);
  for (std::size_t i = 0; i < size_; ++i) by_t0[i] = -by_t0[i];
  for (int j = link_ + 1; j < next; ++j)
    std::copy_n(scratch_.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(j) * size_), size_,
                Column(link_ + 3 + unknown_of[static_cast<std::size_t>(j)]));
  return true;
}

/// From displacements to residuals, through everything that acts on the reading.
void ExtendedColumns::Read(const FitData& data, std::size_t stride, const double* start, std::span<const double> shared,
                           std::span<const double> own, bool derivatives) {
  double* value = Column(unknowns_);
  if (derivatives) std::fill_n(Column(link_ + 2), size_, 0.0);
  bool offset_added = false;
  const auto add_offset = [&] {
    offset_added = true;
    for (std::size_t i = 0; i < size_; ++i) value[i] += start[2];
    if (derivatives) std::fill_n(Column(link_ + 2), size_, 1.0);
  };
  for (const Effect* effect : extension_.readings()) {
    if (!offset_added && effect->stage > ReadingStage::kCurve) add_offset();
    ReadThrough(effect, extension_.CalcLawValues(effect, shared, own), derivatives);
  }
  if (!offset_added) add_offset();
  const double* reading = data.record->y.data() + data.first;
  for (std::size_t i = 0; i < size_; ++i) value[i] -= reading[i * stride];
}

void ExtendedColumns::ReadThrough(const Effect* effect, std::span<const double> law_values, bool derivatives) {
  double* value = Column(unknowns_);
  if (!derivatives) {
    for (std::size_t i = 0; i < size_; ++i)
      value[i] = effect->Read<double>(law_values, clock_[i], fit_start_, value[i]);
    return;
  }
  using T = Dual<6>;
  std::array<T, kMostParameters> p;
  std::array<double*, kMostParameters> column{};
  const auto place = [&](std::span<const Extension::Unknown> unknowns, int first) {
    for (std::size_t j = 0; j < unknowns.size(); ++j) {
      if (unknowns[j].effect != effect) continue;
      const std::size_t parameter = unknowns[j].parameter;
      p[parameter] = T(law_values[parameter]);
      p[parameter].v(1 + static_cast<int>(parameter)) =
          unknowns[j].Parameter().coordinate == Coordinate::kLog ? law_values[parameter] : 1.0;
      column[parameter] = Column(first + static_cast<int>(j));
    }
  };
  place(extension_.shared(), link_ + 3);
  place(extension_.own(), link_ + 3 + static_cast<int>(extension_.shared().size()));
  const std::size_t parameters = effect->parameters.size();
  slope_.resize(size_);
  const bool curved = effect->stage == ReadingStage::kCurve || effect->stage == ReadingStage::kClipped;
  for (std::size_t i = 0; i < size_; ++i) {
    const T out = effect->Read<T>({p.data(), parameters}, clock_[i], fit_start_, T(value[i], 0));
    value[i] = out.a;
    if (curved) slope_[i] = out.v(0);
    for (std::size_t j = 0; j < parameters; ++j) column[j][i] = out.v(1 + static_cast<int>(j));
  }
  if (!curved) return;
  for (int c = 0; c < unknowns_; ++c) {
    double* by_unknown = Column(c);
    if (std::find(column.begin(), column.begin() + static_cast<std::ptrdiff_t>(parameters), by_unknown) !=
        column.begin() + static_cast<std::ptrdiff_t>(parameters))
      continue;  // the effect's own
    for (std::size_t i = 0; i < size_; ++i) by_unknown[i] *= slope_[i];
  }
}

}  // namespace uiclink
