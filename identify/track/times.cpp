#include "identify/track/times.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "identify/upper_median.h"

namespace uiclink::track {
namespace {

constexpr double kGapFrom = 1.5;        // of the step, on an even grid
constexpr double kVariableGapFrom = 3;  // of the median, where steps vary

struct Stamp {
  std::size_t picture;
  double t;
};

/// The coarsest of 1/600 s (QuickTime), 1, 0.1 and 0.01 ms that all stamps are multiples of.
double FindResolution(const std::vector<Stamp>& stamps) {
  for (const double resolution : {1.0 / 600, 1e-3, 1e-4, 1e-5}) {
    const auto whole = [=](const Stamp& s) {
      const double ticks = s.t / resolution;
      return std::abs(ticks - std::round(ticks)) < 1e-4;
    };
    if (std::all_of(stamps.begin(), stamps.end(), whole)) return resolution;
  }
  return 0;
}

/// Stamps that increase; the others count as backwards.
std::vector<Stamp> TakeIncreasing(const std::vector<std::optional<double>>& stamps, int* backwards) {
  std::vector<Stamp> taken;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    if (!stamps[i] || !std::isfinite(*stamps[i])) continue;
    if (!taken.empty() && *stamps[i] <= taken.back().t) {
      ++*backwards;
    } else {
      taken.push_back({i, *stamps[i]});
    }
  }
  return taken;
}

/// Whole steps since the first stamp, and the line through the stamps over them.
struct Grid {
  std::vector<double> n;
  double start = 0, step = 0, largest = 0;  // largest deviation [s]
};

Grid FitGrid(const std::vector<Stamp>& stamps, double step) {
  Grid grid;
  double n = 0, sum_n = 0, sum_t = 0, nn = 0, nt = 0;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    // A picture without a stamp between two that have one takes its place on the grid.
    if (i > 0) n += std::max(1.0, std::round((stamps[i].t - stamps[i - 1].t) / step));
    grid.n.push_back(n);
    sum_n += n, sum_t += stamps[i].t;
  }
  const auto count = static_cast<double>(stamps.size());
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const double from_mean = grid.n[i] - sum_n / count;
    nn += from_mean * from_mean, nt += from_mean * (stamps[i].t - sum_t / count);
  }
  grid.step = nt / nn;
  grid.start = sum_t / count - grid.step * sum_n / count;
  for (std::size_t i = 0; i < stamps.size(); ++i)
    grid.largest = std::max(grid.largest, std::abs(stamps[i].t - grid.start - grid.step * grid.n[i]));
  return grid;
}

/// The last pictures without a time stamp follow at the same rate.
void Continue(const Stamp& last, PictureTimes* times) {
  for (std::size_t i = last.picture + 1; i < times->t.size(); ++i) {
    times->t[i] = last.t + times->step * static_cast<double>(i - last.picture);
    ++times->continued;
  }
  if (times->continued > 0) {
    times->notices.push_back(fmt::format("the last {} pictures have no time stamp: even steps of {:.6g} ms go on",
                                         times->continued, 1e3 * times->step));
  }
}

void UseGrid(const std::vector<Stamp>& stamps, const Grid& grid, PictureTimes* times) {
  times->even = true;
  times->step = grid.step;
  double last = 0;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    last = grid.start + grid.step * grid.n[i];
    times->t[stamps[i].picture] = last;
    if (i == 0) continue;
    const auto pictures = static_cast<int>(stamps[i].picture - stamps[i - 1].picture);
    const int missing = static_cast<int>(std::lround(grid.n[i] - grid.n[i - 1])) - pictures;
    if (missing > 0) times->gaps.push_back({stamps[i].picture - 1, missing});
  }
  if (times->backwards == 0) Continue({stamps.back().picture, last}, times);
}

void UseStamps(const std::vector<Stamp>& stamps, double median, PictureTimes* times) {
  times->even = false;
  times->step = median;
  double shortest = stamps[1].t - stamps[0].t, longest = shortest;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    times->t[stamps[i].picture] = stamps[i].t;
    if (i == 0) continue;
    const double step = stamps[i].t - stamps[i - 1].t;
    shortest = std::min(shortest, step), longest = std::max(longest, step);
    if (step > kVariableGapFrom * median) times->gaps.push_back({stamps[i].picture - 1, std::nullopt});
  }
  times->notices.push_back(
      fmt::format("the rate varies: steps of {:.4g} to {:.4g} ms, as the container's time stamps say", 1e3 * shortest,
                  1e3 * longest));
}

}  // namespace

PictureTimes JudgeTimes(const std::vector<std::optional<double>>& stamps, std::optional<double> rate_hz) {
  if (stamps.size() < 2) throw std::invalid_argument("JudgeTimes: needs two pictures or more");
  PictureTimes times;
  times.t.resize(stamps.size());
  if (rate_hz) {
    times.step = 1 / *rate_hz;
    for (std::size_t i = 0; i < stamps.size(); ++i) times.t[i] = static_cast<double>(i) / *rate_hz;
    return times;
  }
  const std::vector<Stamp> taken = TakeIncreasing(stamps, &times.backwards);
  if (taken.size() < 2) return times;
  std::vector<double> steps;
  for (std::size_t i = 1; i < taken.size(); ++i) steps.push_back(taken[i].t - taken[i - 1].t);
  const double median = UpperMedian(steps);
  times.resolution = FindResolution(taken);
  // The median of rounded steps may be off by a rounding, which adds up: the line's own step is taken once more.
  Grid grid = FitGrid(taken, median);
  grid = FitGrid(taken, grid.step);
  if (grid.largest <= 0.6 * times.resolution + 1e-4 * median && grid.step * kGapFrom > median) {
    UseGrid(taken, grid, &times);
  } else {
    UseStamps(taken, median, &times);
  }
  return times;
}

}  // namespace uiclink::track
