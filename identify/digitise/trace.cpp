#include "identify/digitise/trace.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace uiclink::digitise {
namespace {

constexpr float kInk = 0.45F;      // share from which a pixel is ink
constexpr double kJumpCost = 4.0;  // ink that a jump of one pixel costs
constexpr double kHoleCost = 0.3;  // the same where holes of that size are bridged anyway
constexpr double kSkipCost = 0.5;  // ink that a column without a stroke costs

using Columns = std::vector<std::vector<Stroke>>;

/// Runs of ink in a column, joined where at most `bridge` pixels lie between them; unknown pixels count as bridges of
/// no length.
std::vector<Stroke> FindRuns(const InkLayer& layer, const Inks& inks, int x, int bridge) {
  std::vector<Stroke> runs;
  int hole = std::numeric_limits<int>::max() / 2;
  for (int y = inks.y0; y <= inks.y1; ++y) {
    if (layer.weight.At(x, y) <= 0) continue;
    if (layer.share.At(x, y) < kInk) {
      ++hole;
      continue;
    }
    if (runs.empty() || hole > bridge) {
      runs.push_back({x, y - 0.5, y + 0.5, 1});
    } else {
      runs.back().high = y + 0.5;
      ++runs.back().ink;
    }
    hole = 0;
  }
  // Edges to a part of a pixel, by the share of ink in the pixel beyond.
  for (Stroke& run : runs) {
    const int above = static_cast<int>(std::lround(run.low - 0.5)),
              below = static_cast<int>(std::lround(run.high + 0.5));
    const auto beyond = [&](int y) { return double(std::clamp(layer.share.At(x, y), 0.0F, kInk)); };
    if (above >= inks.y0) run.low -= beyond(above);
    if (below <= inks.y1) run.high += beyond(below);
  }
  constexpr std::size_t kMostRuns = 12;
  if (runs.size() > kMostRuns) {
    std::nth_element(runs.begin(), runs.begin() + kMostRuns, runs.end(),
                     [](auto& a, auto& b) { return a.ink > b.ink; });
    runs.resize(kMostRuns);
  }
  return runs;
}

double Apart(const Stroke& a, const Stroke& b) { return std::max({0.0, a.low - b.high, b.low - a.high}); }

/// Holes of a dashed line cost little, jumps beyond them much.
double JumpCost(double apart, double bridge) {
  return kHoleCost * std::min(apart, bridge) + kJumpCost * std::max(0.0, apart - bridge);
}

/// The chain with most ink; columns that lie up to `reach` apart may follow each other.
std::vector<Stroke> FindChain(const Columns& columns, int reach, int bridge) {
  struct Node {
    double value;
    int column, run;  // of the one before; -1: none
  };
  std::vector<std::vector<Node>> nodes(columns.size());
  double best = 0;
  int best_column = -1, best_run = -1;
  for (int c = 0; c < static_cast<int>(columns.size()); ++c) {
    for (const Stroke& run : columns[std::size_t(c)]) {
      Node node{double(run.ink), -1, -1};
      for (int before = c - 1; before >= std::max(0, c - 1 - reach); --before) {
        const auto& others = columns[std::size_t(before)];
        for (std::size_t r = 0; r < others.size(); ++r) {
          const double value = nodes[std::size_t(before)][r].value + run.ink - JumpCost(Apart(run, others[r]), bridge) -
                               kSkipCost * (c - before - 1);
          if (value > node.value) node = {value, before, static_cast<int>(r)};
        }
      }
      nodes[std::size_t(c)].push_back(node);
      if (node.value > best)
        best = node.value, best_column = c, best_run = static_cast<int>(nodes[std::size_t(c)].size()) - 1;
    }
  }
  std::vector<Stroke> chain;
  while (best_column >= 0) {
    chain.push_back(columns[std::size_t(best_column)][std::size_t(best_run)]);
    const Node& node = nodes[std::size_t(best_column)][std::size_t(best_run)];
    best_column = node.column, best_run = node.run;
  }
  std::reverse(chain.begin(), chain.end());
  return chain;
}

double TotalInk(const InkLayer& layer, const Inks& inks) {
  double total = 0;
  for (int y = inks.y0; y <= inks.y1; ++y)
    for (int x = inks.x0; x <= inks.x1; ++x) total += layer.weight.At(x, y) > 0 && layer.share.At(x, y) >= kInk;
  return total;
}

}  // namespace

Trace FindTrace(const InkLayer& layer, const Inks& inks) {
  const double total = TotalInk(layer, inks);
  const int longest = std::max(12, (inks.x1 - inks.x0) / 10);
  Trace best;
  for (const int bridge : {3, 8, 16, 30}) {
    Columns columns;
    for (int x = inks.x0; x <= inks.x1; ++x) columns.push_back(FindRuns(layer, inks, x, bridge));
    Trace trace{FindChain(columns, longest, bridge), total, 0, bridge};
    for (const Stroke& stroke : trace.strokes) trace.ink += stroke.ink;
    // A wider bridge has to find more ink than noise would give it.
    if (best.strokes.empty() || trace.ink > best.ink + 0.01 * total) best = trace;
  }
  return best;
}

double HalfWidth(const Trace& trace, const InkLayer& layer) {
  std::vector<double> extents;
  for (const Stroke& stroke : trace.strokes) {
    const int y =
        std::clamp(static_cast<int>(std::lround(0.5 * (stroke.low + stroke.high))), 0, layer.share.height - 1);
    double across = 0;
    for (const int way : {-1, 1}) {
      for (int x = way < 0 ? stroke.x : stroke.x + 1; x >= 0 && x < layer.share.width; x += way) {
        if (layer.weight.At(x, y) <= 0 || layer.share.At(x, y) < 0.1F) break;
        across += std::min(1.0F, layer.share.At(x, y));
      }
    }
    if (across > 0) extents.push_back(std::min(across, stroke.high - stroke.low));
  }
  if (extents.empty()) return 0.5;
  const auto rank = extents.begin() + static_cast<std::ptrdiff_t>(extents.size() / 3);
  std::nth_element(extents.begin(), rank, extents.end());
  return 0.5 * std::clamp(*rank, 1.0, 14.0);
}

bool LooksDrawn(const Trace& trace, double half_width) {
  const std::vector<Stroke>& s = trace.strokes;
  if (s.empty()) return false;
  const auto centre = [&](std::size_t i) { return 0.5 * (s[i].low + s[i].high); };
  double letters = 0;
  for (std::size_t i = 1; i + 1 < s.size(); ++i) {
    const double climb = 0.5 * std::abs(centre(i + 1) - centre(i - 1));
    letters += s[i].high - s[i].low > 2 * (climb + 2 * half_width * std::hypot(1.0, climb)) + 1;
  }
  return letters < 0.5 * trace.Columns();
}

double Travel(const Trace& trace) {
  const auto [low, high] = std::minmax_element(trace.strokes.begin(), trace.strokes.end(),
                                               [](const Stroke& a, const Stroke& b) { return a.low < b.low; });
  return trace.strokes.empty() ? 0 : high->low - low->low;
}

double Coverage(const Trace& trace, int hole) {
  if (trace.strokes.size() < 2) return 0;
  double covered = 1;
  for (std::size_t i = 1; i < trace.strokes.size(); ++i) {
    const int step = trace.strokes[i].x - trace.strokes[i - 1].x;
    covered += step <= hole + 1 ? step : 1;
  }
  return covered / (trace.strokes.back().x - trace.strokes.front().x + 1);
}

std::vector<double> RollDisc(const Trace& trace, double radius, int x0, int x1) {
  const auto size = static_cast<std::size_t>(x1 - x0 + 1);
  const double none = std::nan("");
  std::vector<double> low(size, none), high(size, none);
  for (const Stroke& stroke : trace.strokes) {
    low[std::size_t(stroke.x - x0)] = stroke.low;
    high[std::size_t(stroke.x - x0)] = stroke.high;
  }
  std::vector<double> y(size, none);
  const int reach = static_cast<int>(std::ceil(radius + 0.5));
  for (int i = 0; i < static_cast<int>(size); ++i) {
    if (std::isnan(low[std::size_t(i)])) continue;
    double from_high = 1e9, from_low = -1e9;
    for (int j = std::max(0, i - reach); j <= std::min(static_cast<int>(size) - 1, i + reach); ++j) {
      if (std::isnan(low[std::size_t(j)])) continue;
      const double off = std::max(0.0, std::abs(j - i) - 0.5);
      if (off > radius) continue;
      const double rise = std::sqrt(radius * radius - off * off);
      from_high = std::min(from_high, high[std::size_t(j)] - rise);
      from_low = std::max(from_low, low[std::size_t(j)] + rise);
    }
    // Which way it turns here: centres beside against the centre.
    const auto centre = [&](int k) {
      k = std::clamp(k, 0, static_cast<int>(size) - 1);
      return 0.5 * (low[std::size_t(k)] + high[std::size_t(k)]);
    };
    const double turn = centre(i - reach - 1) + centre(i + reach + 1) - 2 * centre(i);
    if (!(from_high - from_low > 1.0) || std::isnan(turn)) {
      y[std::size_t(i)] = 0.5 * (from_high + from_low);
    } else {
      y[std::size_t(i)] = turn < 0 ? from_high : from_low;
    }
  }
  // Bridges, and level ends.
  std::size_t last = size;
  for (std::size_t i = 0; i < size; ++i) {
    if (std::isnan(y[i])) continue;
    const std::size_t begin = last == size ? 0 : last + 1;
    for (std::size_t k = begin; k < i; ++k)
      y[k] = last == size ? y[i] : y[last] + (y[i] - y[last]) * double(k - last) / double(i - last);
    last = i;
  }
  for (std::size_t k = last == size ? 0 : last + 1; k < size; ++k) y[k] = last == size ? 0 : y[last];
  return y;
}

}  // namespace uiclink::digitise
