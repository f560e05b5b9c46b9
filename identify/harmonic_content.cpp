#include "identify/harmonic_content.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace uiclink {
namespace {

constexpr int kHarmonics = 3;
constexpr int kUnknowns = 1 + 2 * kHarmonics;
using Row = Eigen::Matrix<double, kUnknowns, 1>;

/// Half the distance of a turn from its neighbours.
std::vector<double> CalcTurnAmplitudes(std::span<const Turn> turns) {
  std::vector<double> amplitudes(turns.size());
  for (std::size_t i = 1; i + 1 < turns.size(); ++i) amplitudes[i] = 0.25 * (Span(turns, i - 1) + Span(turns, i));
  amplitudes.front() = 0.5 * Span(turns, 0);
  amplitudes.back() = 0.5 * Span(turns, turns.size() - 2);
  return amplitudes;
}

/// Constant, then cosine and sine of each harmonic. The constant has the size of the others.
Row MakeRow(const LocalPhase& local, std::size_t i) {
  const double c = std::cos(local.phase[i]), s = std::sin(local.phase[i]), a = local.amplitude[i];
  Row row;
  row[0] = local.amplitude[0];
  double cn = 1, sn = 0;
  for (int h = 1; h <= kHarmonics; ++h) {
    const double next = cn * c - sn * s;
    sn = sn * c + cn * s, cn = next;
    const double side = h % 2 == 0 ? 1 : local.side;  // even functions of the motion do not know its side
    row[2 * h - 1] = side * a * cn;
    row[2 * h] = side * a * sn;
  }
  return row;
}

}  // namespace

LocalPhase CalcLocalPhase(std::span<const double> t, std::span<const Turn> turns) {
  LocalPhase local;
  if (turns.size() < 3) return local;
  local.side = turns[0].y > turns[1].y ? 1 : -1;
  const std::vector<double> amplitudes = CalcTurnAmplitudes(turns);
  std::size_t i = 0;
  for (const double time : t) {
    while (i + 2 < turns.size() && time > turns[i + 1].t) ++i;
    const double share = (time - turns[i].t) / (turns[i + 1].t - turns[i].t);
    if (share > 1) break;
    local.phase.push_back(std::numbers::pi * (static_cast<double>(i) + share));
    local.amplitude.push_back(amplitudes[i] + share * (amplitudes[i + 1] - amplitudes[i]));
  }
  return local;
}

std::array<double, 4> CalcHarmonicContent(std::span<const double> t, std::span<const double> y,
                                          std::span<const Turn> turns) {
  const LocalPhase local = CalcLocalPhase(t, turns);
  std::array<double, 4> content;
  content.fill(std::numeric_limits<double>::quiet_NaN());
  if (local.phase.size() <= kUnknowns) return content;
  Eigen::Matrix<double, kUnknowns, kUnknowns> normal = Eigen::Matrix<double, kUnknowns, kUnknowns>::Zero();
  Row rhs = Row::Zero();
  for (std::size_t i = 0; i < local.phase.size(); ++i) {
    const Row row = MakeRow(local, i);
    normal.noalias() += row * row.transpose();
    rhs += (y[i] - turns[0].y) * row;
  }
  const Row solution = normal.ldlt().solve(rhs);
  for (int j = 0; j < 4; ++j) content[static_cast<std::size_t>(j)] = solution[kUnknowns - 4 + j];
  return content;
}

}  // namespace uiclink
