#include "identify/digitise/inks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "identify/digitise/straight_lines.h"
#include "identify/digitise/views.h"

namespace uiclink::digitise {
namespace {

constexpr double kSameInk = 0.20;   // directions closer than this are one ink [rad]: black and dark blue are 0.28 apart
constexpr double kOtherInk = 0.32;  // directions further from every ink than this are of none [rad]
constexpr double kFaintest = 30;    // ink from here on [levels]

double Norm(const Colour& c) { return std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]); }
Colour Less(const Colour& a, const Colour& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double Dot(const Colour& a, const Colour& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Colour Unit(const Colour& c) {
  const double norm = std::max(Norm(c), 1e-9);
  return {c[0] / norm, c[1] / norm, c[2] / norm};
}
double Angle(const Colour& a, const Colour& b) { return std::acos(std::clamp(Dot(Unit(a), Unit(b)), -1.0, 1.0)); }

Colour At(const Picture& picture, int x, int y) {
  const std::uint8_t* p = picture.At(x, y);
  return {double(p[0]), double(p[1]), double(p[2])};
}

/// Mean of the most frequent colours (in bins of 16 levels).
void FindPaper(const Picture& picture, Inks* inks) {
  std::map<int, int> counts;
  for (int y = inks->y0; y <= inks->y1; y += 2)
    for (int x = inks->x0; x <= inks->x1; x += 2) {
      const std::uint8_t* p = picture.At(x, y);
      ++counts[(p[0] / 16) * 256 + (p[1] / 16) * 16 + p[2] / 16];
    }
  const int mode =
      std::max_element(counts.begin(), counts.end(), [](auto& a, auto& b) { return a.second < b.second; })->first;
  Colour centre{mode / 256 * 16 + 8.0, mode / 16 % 16 * 16 + 8.0, mode % 16 * 16 + 8.0};
  for (int pass = 0; pass < 3; ++pass) {
    Colour sum{};
    double count = 0, square = 0;
    for (int y = inks->y0; y <= inks->y1; ++y)
      for (int x = inks->x0; x <= inks->x1; ++x) {
        const Colour off = Less(At(picture, x, y), centre);
        if (Norm(off) > 26) continue;
        for (std::size_t c = 0; c < 3; ++c) sum[c] += off[c];
        square += Dot(off, off) / 3;
        count += 1;
      }
    for (std::size_t c = 0; c < 3; ++c) centre[c] += sum[c] / count;
    inks->noise = std::sqrt(square / count);
  }
  inks->paper = centre;
}

/// Paper less pixel, and its means over 5x5 pixels.
struct Absorbed {
  cv::Mat raw, mean;
};

Absorbed Absorb(const Picture& picture, const Colour& paper) {
  Absorbed absorbed;
  cv::Mat pixels;
  View(picture).convertTo(pixels, CV_32FC3);
  absorbed.raw = cv::Scalar(paper[0], paper[1], paper[2]) - pixels;
  cv::blur(absorbed.raw, absorbed.mean, {5, 5});
  return absorbed;
}

Colour Take(const cv::Mat& mat, int x, int y) {
  const auto& p = mat.at<cv::Vec3f>(y, x);
  return {p[0], p[1], p[2]};
}

/// Which pixels are ink at all, straight lines left out.
template <typename Use>
void ForEachInk(const Inks& inks, const Absorbed& absorbed, double faintest, Use use) {
  std::vector<char> row_line(std::size_t(absorbed.raw.rows)), column_line(std::size_t(absorbed.raw.cols));
  for (const int y : inks.level_lines) row_line[std::size_t(y)] = 1;
  for (const int x : inks.upright_lines) column_line[std::size_t(x)] = 1;
  for (int y = inks.y0; y <= inks.y1; ++y) {
    if (row_line[std::size_t(y)]) continue;
    for (int x = inks.x0; x <= inks.x1; ++x) {
      if (column_line[std::size_t(x)]) continue;
      const Colour raw = Take(absorbed.raw, x, y);
      if (Norm(raw) > faintest) use(x, y, raw);
    }
  }
}

struct Directions {
  std::vector<Colour> units;  ///< by falling weight, at least kSameInk apart
  double covered = 0;         ///< part of the ink within half that angle of one of them
};

/// @param sharp  pixels count as they are; else their means over 5x5
Directions FindDirections(const Inks& inks, const Absorbed& absorbed, bool sharp) {
  constexpr int kBins = 24;
  std::map<std::array<int, 3>, std::pair<double, Colour>> bins;
  double all = 0;
  ForEachInk(inks, absorbed, kFaintest, [&](int x, int y, const Colour& raw) {
    const Colour unit = Unit(sharp ? raw : Take(absorbed.mean, x, y));
    const std::array<int, 3> bin{static_cast<int>(std::lround(unit[0] * kBins)),
                                 static_cast<int>(std::lround(unit[1] * kBins)),
                                 static_cast<int>(std::lround(unit[2] * kBins))};
    auto& [weight, sum] = bins[bin];
    const double w = Norm(raw);
    weight += w;
    for (std::size_t c = 0; c < 3; ++c) sum[c] += w * unit[c];
    all += w;
  });
  std::vector<std::pair<double, Colour>> sorted;
  for (const auto& [bin, content] : bins) sorted.push_back(content);
  Directions found;
  std::vector<Colour>& directions = found.units;
  while (directions.size() < 8) {
    // The heaviest neighbourhood among what no direction has taken yet.
    double best = 0;
    Colour direction{};
    for (const auto& [weight, sum] : sorted) {
      if (std::any_of(directions.begin(), directions.end(), [&](const Colour& d) { return Angle(d, sum) < kSameInk; }))
        continue;
      double around = 0;
      Colour total{};
      for (const auto& [other_weight, other] : sorted) {
        if (Angle(other, sum) > 0.6 * kSameInk) continue;
        around += other_weight;
        for (std::size_t c = 0; c < 3; ++c) total[c] += other[c];
      }
      if (around > best) best = around, direction = Unit(total);
    }
    if (best < 0.02 * all) break;
    directions.push_back(direction);
  }
  for (const auto& [weight, sum] : sorted) {
    const bool near = std::any_of(directions.begin(), directions.end(),
                                  [&](const Colour& d) { return Angle(d, sum) < 0.5 * kSameInk; });
    found.covered += near ? weight / all : 0;
  }
  return found;
}

int Nearest(const std::vector<Colour>& directions, const Colour& mean) {
  int nearest = -1;
  double least = kOtherInk;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const double angle = Angle(directions[i], mean);
    if (angle < least) least = angle, nearest = static_cast<int>(i);
  }
  return nearest;
}

double Quantile(std::vector<float> values, double q) {
  if (values.empty()) return 0;
  const auto rank = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), rank, values.end());
  return *rank;
}

/// Weights of luminance and colour in JPEG: colour is stored at half resolution and coarser.
struct Luma {
  double y, cb, cr;
  explicit Luma(const Colour& c)
      : y(0.114 * c[0] + 0.587 * c[1] + 0.299 * c[2]), cb(0.33 * 0.564 * (c[0] - y)), cr(0.33 * 0.713 * (c[2] - y)) {}
  double Dot(const Luma& o) const { return y * o.y + cb * o.cb + cr * o.cr; }
};

/// Colour of a straight line where nothing crosses it: of its pixels the one with the 40 % quantile of darkness.
Colour LineColour(std::vector<Colour> absorbed) {
  const auto rank = absorbed.begin() + static_cast<std::ptrdiff_t>(absorbed.size() * 2 / 5);
  std::nth_element(absorbed.begin(), rank, absorbed.end(),
                   [](const Colour& a, const Colour& b) { return Norm(a) < Norm(b); });
  return *rank;
}

/// On a straight line the ink is measured against the line's colour instead of the paper's; where both are alike
/// nothing can be said.
class Ground {
 public:
  Ground(const Inks& inks, const Absorbed& absorbed)
      : rows_(std::size_t(absorbed.raw.rows)), columns_(std::size_t(absorbed.raw.cols)) {
    row_line_.resize(rows_.size());
    column_line_.resize(columns_.size());
    for (const int y : inks.level_lines) {
      std::vector<Colour> pixels;
      for (int x = inks.x0; x <= inks.x1; ++x) pixels.push_back(Take(absorbed.raw, x, y));
      rows_[std::size_t(y)] = LineColour(std::move(pixels));
      row_line_[std::size_t(y)] = 1;
    }
    for (const int x : inks.upright_lines) {
      std::vector<Colour> pixels;
      for (int y = inks.y0; y <= inks.y1; ++y) pixels.push_back(Take(absorbed.raw, x, y));
      columns_[std::size_t(x)] = LineColour(std::move(pixels));
      column_line_[std::size_t(x)] = 1;
    }
  }
  bool IsLine(int x, int y) const { return row_line_[std::size_t(y)] || column_line_[std::size_t(x)]; }
  bool IsCrossing(int x, int y) const { return row_line_[std::size_t(y)] && column_line_[std::size_t(x)]; }
  const Colour& At(int x, int y) const {
    return row_line_[std::size_t(y)] ? rows_[std::size_t(y)] : columns_[std::size_t(x)];
  }

 private:
  std::vector<Colour> rows_, columns_;
  std::vector<char> row_line_, column_line_;
};

/// What a pixel is made of: one ink, or two where they cross or lie side by side.
class Unmixer {
 public:
  struct Shares {
    double own = 0, other = 0;
  };

  Unmixer(const Inks& inks, std::size_t which) : which_(which), tolerance_(10 + 3 * inks.noise) {
    for (const Ink& ink : inks.inks) {
      full_.push_back(Less(inks.paper, ink.colour));
      units_.push_back(Unit(full_.back()));
    }
  }

  bool IsOther(const Colour& mean) const {
    const int nearest = Nearest(units_, mean);
    return nearest >= 0 && std::size_t(nearest) != which_;
  }

  Shares Unmix(const Colour& raw) const {
    const double own = Dot(raw, full_[which_]) / Dot(full_[which_], full_[which_]);
    double least = Residual(raw, full_[which_], own);
    Shares best{own, 0};
    if (least < tolerance_ || Norm(raw) < tolerance_) return best;
    for (std::size_t i = 0; i < full_.size(); ++i) {
      if (i == which_) continue;
      const double share = Dot(raw, full_[i]) / Dot(full_[i], full_[i]);
      const double residual = Residual(raw, full_[i], share);
      if (residual < least) least = residual, best = {0, share};
    }
    if (least < tolerance_) return best;
    for (std::size_t i = 0; i < full_.size(); ++i)
      for (std::size_t j = i + 1; j < full_.size(); ++j) TryPair(raw, i, j, &least, &best);
    return best;
  }

 private:
  static double Residual(const Colour& raw, const Colour& full, double share) {
    return Norm({raw[0] - share * full[0], raw[1] - share * full[1], raw[2] - share * full[2]});
  }

  void TryPair(const Colour& raw, std::size_t i, std::size_t j, double* least, Shares* best) const {
    const Colour &a = full_[i], &b = full_[j];
    const double aa = Dot(a, a), ab = Dot(a, b), bb = Dot(b, b), determinant = aa * bb - ab * ab;
    if (determinant < 1e-6 * aa * bb) return;
    const double p = (Dot(raw, a) * bb - Dot(raw, b) * ab) / determinant,
                 q = (Dot(raw, b) * aa - Dot(raw, a) * ab) / determinant;
    if (p < 0 || q < 0) return;
    const double residual =
        Norm({raw[0] - p * a[0] - q * b[0], raw[1] - p * a[1] - q * b[1], raw[2] - p * a[2] - q * b[2]});
    if (residual >= *least) return;
    *least = residual;
    *best = {i == which_ ? p : j == which_ ? q : 0, i == which_ ? q : j == which_ ? p : p + q};
  }

  std::size_t which_;
  double tolerance_;
  std::vector<Colour> full_, units_;
};

}  // namespace

Inks FindInks(const Page& page) {
  Inks inks;
  const double inset = page.border > 0 ? 0.5 * page.border + 1.5 : 0;
  inks.x0 = static_cast<int>(std::ceil(page.left + inset)), inks.x1 = static_cast<int>(std::floor(page.right - inset));
  inks.y0 = static_cast<int>(std::ceil(page.top + inset)), inks.y1 = static_cast<int>(std::floor(page.bottom - inset));
  FindPaper(page.picture, &inks);
  const Absorbed absorbed = Absorb(page.picture, inks.paper);
  FindStraightLines(page, &inks);
  // In pictures without JPEG's coarse colours nearly every pixel has the colour of one ink, and means over several
  // pixels only add mixtures; smeared colours look like further inks, which means bring together again.
  constexpr double kSharp = 0.9;
  Directions found = FindDirections(inks, absorbed, true);
  Directions means = FindDirections(inks, absorbed, false);
  inks.sharp = found.covered > kSharp && found.units.size() <= means.units.size();
  if (!inks.sharp) found = std::move(means);
  const std::vector<Colour>& directions = found.units;
  std::vector<std::vector<float>> strengths(directions.size());
  ForEachInk(inks, absorbed, kFaintest, [&](int x, int y, const Colour& raw) {
    const int nearest = Nearest(directions, inks.sharp ? raw : Take(absorbed.mean, x, y));
    if (nearest >= 0)
      strengths[std::size_t(nearest)].push_back(static_cast<float>(Dot(raw, directions[std::size_t(nearest)])));
  });
  for (std::size_t i = 0; i < directions.size(); ++i) {
    // Among all inky pixels the darkest twentieth is the inside of a line, or the best that a thin line gets.
    const double strength = Quantile(strengths[i], 0.95);
    Ink ink{.colour = {}, .pixels = double(strengths[i].size())};
    for (std::size_t c = 0; c < 3; ++c)
      ink.colour[c] = std::clamp(inks.paper[c] - strength * directions[i][c], 0.0, 255.0);
    if (strength > kFaintest) inks.inks.push_back(ink);
  }
  std::stable_sort(inks.inks.begin(), inks.inks.end(), [](const Ink& a, const Ink& b) { return a.pixels > b.pixels; });
  return inks;
}

InkLayer MakeLayer(const Page& page, const Inks& inks, std::size_t which) {
  const Absorbed absorbed = Absorb(page.picture, inks.paper);
  const Ground ground(inks, absorbed);
  const Unmixer unmixer(inks, which);
  const Colour full = Less(inks.paper, inks.inks[which].colour);
  const Luma full_luma(full);
  InkLayer layer{Plane(page.picture.width, page.picture.height), Plane(page.picture.width, page.picture.height)};
  cv::Mat foreign = cv::Mat::zeros(page.picture.height, page.picture.width, CV_8U);
  for (int y = inks.y0; y <= inks.y1; ++y) {
    for (int x = inks.x0; x <= inks.x1; ++x) {
      const Colour raw = Take(absorbed.raw, x, y);
      float& share = layer.share.At(x, y);
      float& weight = layer.weight.At(x, y);
      if (ground.IsLine(x, y)) {
        const Colour& line = ground.At(x, y);
        const Luma left(Less(full, line));
        const double distinct = left.Dot(left) / full_luma.Dot(full_luma);
        if (distinct < 0.16 || ground.IsCrossing(x, y)) continue;
        share = static_cast<float>(Luma(Less(raw, line)).Dot(left) / left.Dot(left));
        weight = static_cast<float>(distinct);
        continue;
      }
      if (inks.sharp) {
        const Unmixer::Shares shares = unmixer.Unmix(raw);
        share = static_cast<float>(shares.own);
        weight = shares.other > 0.5 ? 0 : static_cast<float>(std::clamp(1 - 1.5 * shares.other, 0.0, 1.0));
        continue;
      }
      share = static_cast<float>(Luma(raw).Dot(full_luma) / full_luma.Dot(full_luma));
      weight = 1;
      foreign.at<std::uint8_t>(y, x) = Norm(raw) > kFaintest && unmixer.IsOther(Take(absorbed.mean, x, y));
    }
  }
  cv::dilate(foreign, foreign, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
  for (int y = inks.y0; y <= inks.y1; ++y)
    for (int x = inks.x0; x <= inks.x1; ++x)
      if (foreign.at<std::uint8_t>(y, x)) layer.weight.At(x, y) = 0;
  return layer;
}

double InkDistance(const Colour& a, const Colour& b, const Colour& paper) {
  const Colour da = Less(paper, a), db = Less(paper, b);
  return Angle(da, db) + 0.5 * std::abs(std::log(std::max(Norm(da), 1.0) / std::max(Norm(db), 1.0)));
}

}  // namespace uiclink::digitise
