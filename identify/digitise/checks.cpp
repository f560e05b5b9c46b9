#include "identify/digitise/checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "data/input_error.h"

namespace uiclink::digitise {
namespace {

// Limits. Correct readings of the styles in tests/validation/digitise_test.cpp stay a factor of two inside them.
constexpr double kLeastFound = 0.85;    // of the line read must lie on ink, dashes aside
constexpr double kMostOutliers = 0.03;  // of the pixels on the line may differ by more than 0.4
constexpr double kMostRms = 0.13;       // of drawn less seen ink there
constexpr double kMostBridge = 1.0;     // standard deviation across the line up to which a hidden part is bridged [px]
constexpr double kSecondCurve = 0.3;    // of the width that other ink of the colour may cover as one curve
constexpr double kMostLeftOut = 0.2;    // of the width
constexpr double kLeastRoom = 1.2;      // white between neighbouring swings [px]

/// Turning points of the read curve that come back by `back` pixels or more.
std::vector<ArcStep> Turns(const LineFit& fit, double back) {
  std::vector<ArcStep> turns;
  ArcStep extreme = fit.arc.front();
  int way = 0;
  for (const ArcStep& step : fit.arc) {
    const double off = step.y - extreme.y;
    if (way == 0 && std::abs(off) > back) way = off > 0 ? 1 : -1;
    if (way * off >= 0) extreme = step;
    if (way * off < -back) turns.push_back(extreme), way = -way, extreme = step;
  }
  return turns;
}

void RequireInside(const Reading& r, const std::string& name) {
  if (r.page.border <= 0) return;
  const double margin = 0.5 * r.page.border + 0.5 * r.fit.profile.width + 1.0;
  for (const ArcStep& step : r.fit.arc) {
    if (step.x < r.readable.first || step.x > r.readable.last) continue;
    if (step.y > r.page.top + margin && step.y < r.page.bottom - margin) continue;
    throw InputError(name, 0,
                     fmt::format("expected a curve inside the frame, found it cut off at the {} near t = {:.3g} s",
                                 step.y > r.page.top + margin ? "bottom" : "top", r.page.T(step.x)));
  }
}

/// Between neighbouring branches there must be paper to see.
void RequireResolved(const Reading& r, const std::string& name) {
  const double tall = std::max(6.0, 3 * r.fit.profile.width);
  const std::vector<ArcStep> turns = Turns(r.fit, tall);
  for (std::size_t i = 2; i < turns.size(); ++i) {
    const double room = 0.5 * (turns[i].x - turns[i - 2].x) - r.fit.profile.width - r.fit.profile.blur;
    if (room >= kLeastRoom) continue;
    throw InputError(name, 0,
                     fmt::format("expected swings that can be told apart, found them {:.1f} px wide near t = {:.3g} s, "
                                 "drawn {:.1f} px thick; use a larger picture, or one of a part of the record",
                                 turns[i].x - turns[i - 2].x, r.page.T(turns[i].x), r.fit.profile.width));
  }
}

/// Ink of the colour that lies off the curve: is it another curve?
void RequireOneCurve(const Reading& r, const std::string& name, Digitised* read) {
  const double near = 0.5 * r.fit.profile.width + 2 * r.fit.profile.blur + 1.5;
  const Plane distance = DistanceFromCurve(r.fit, r.page.picture.width, r.page.picture.height, near + 1);
  InkLayer rest = r.layer;
  double ink = 0, off = 0;
  for (int y = r.inks.y0; y <= r.inks.y1; ++y) {
    for (int x = r.inks.x0; x <= r.inks.x1; ++x) {
      if (r.layer.weight.At(x, y) <= 0 || r.layer.share.At(x, y) < 0.45F) continue;
      const bool on_curve = distance.At(x, y) < near && x >= r.readable.first - 2 && x <= r.readable.last + 2;
      ink += 1, off += !on_curve;
      if (on_curve) rest.weight.At(x, y) = 0;
    }
  }
  read->ink_explained = ink > 0 ? 1 - off / ink : 0;
  if (off < 16) return;
  const Trace second = FindTrace(rest, r.inks);
  if (second.strokes.empty()) return;
  const double reach = second.strokes.back().x - second.strokes.front().x + 1;
  const double width = r.readable.last - r.readable.first + 1;
  if (reach > kSecondCurve * width && second.Columns() > 0.4 * reach && LooksDrawn(second, 0.5 * r.fit.profile.width)) {
    throw InputError(name, 0,
                     fmt::format("expected one {} curve, found ink of that colour off the curve over {:.0f} % of its "
                                 "width: a second curve of the same colour, or swings that cannot be told apart",
                                 read->colour, 100 * reach / width));
  }
  if (read->ink_explained < 0.75)
    read->warnings.push_back(fmt::format("{:.0f} % of the ink of this colour is not on the curve (legend, text?)",
                                         100 * (1 - read->ink_explained)));
}

/// Ink under the curve where it should be. Dashes have holes of one length; other holes are faults.
void CheckLine(const Reading& r, const std::string& name, Digitised* read) {
  std::vector<double> holes;
  double known = 0, inked = 0, hole = 0;
  for (const ArcStep& step : r.fit.arc) {
    if (step.x < r.readable.first || step.x > r.readable.last || r.readable.InGap(step.x) || !step.known) continue;
    known += 1;
    inked += step.inked;
    if (!step.inked) {
      hole += 1;
    } else if (hole > 0) {
      holes.push_back(hole), hole = 0;
    }
  }
  double dashes = 0;
  if (holes.size() > 12) {  // a dashed line: its holes, up to twice their median, belong to it
    std::vector<double> sorted = holes;
    std::sort(sorted.begin(), sorted.end());
    const double usual = sorted[sorted.size() / 2];
    if (usual >= 2)
      for (const double h : holes) dashes += h <= 2 * usual + 3 ? h : 0;
  }
  read->line_found = known - dashes > 0 ? inked / (known - dashes) : 0;
  read->rms_share = r.fit.rms, read->outliers = r.fit.outliers;
  read->columns_read = r.readable.columns_read, read->bridged_px = r.readable.longest_bridge;
  if (read->line_found < kLeastFound || inked < 0.3 * known) {
    throw InputError(
        name, 0,
        fmt::format("expected ink all along the curve, found it under {:.0f} % of what was read; choose the "
                    "curve (--curve), or use a cleaner picture",
                    100 * std::min(read->line_found, inked / std::max(1.0, known))));
  }
  if (read->outliers > kMostOutliers || read->rms_share > kMostRms) {
    throw InputError(name, 0,
                     fmt::format("expected a curve that, drawn again, looks like the picture; found {:.1f} % of its "
                                 "pixels wrong (rms {:.2f} of full ink)",
                                 100 * read->outliers, read->rms_share));
  }
}

/// Turns sharper than the knots resolve: wiggles from pixel to pixel that no drawn motion has.
void CheckSmooth(const Reading& r, Digitised* read) {
  const std::vector<ArcStep> turns = Turns(r.fit, std::max(1.5, r.fit.profile.width));
  int sharp = 0;
  for (std::size_t i = 2; i < turns.size(); ++i) sharp += turns[i].x - turns[i - 2].x < 4 * r.fit.curve.spacing();
  if (sharp > 0)
    read->warnings.push_back(
        fmt::format("{} turn{} of the curve narrower than four knots ({:.1f} px): look at the overlay", sharp,
                    sharp == 1 ? " is" : "s are", 4 * r.fit.curve.spacing()));
}

}  // namespace

bool Readability::InGap(double x) const {
  return std::any_of(gaps.begin(), gaps.end(), [=](const auto& gap) { return x > gap.first && x < gap.second; });
}

Readability FindReadable(const LineFit& fit, const Trace& trace) {
  Readability readable;
  readable.first = trace.strokes.front().x, readable.last = trace.strokes.back().x;
  const std::vector<ArcStep>& arc = fit.arc;
  const auto seen = [](const ArcStep& s) { return s.known && s.inked; };
  // Beyond the first and the last ink that lies on the curve nothing is known.
  const auto front =
      std::find_if(arc.begin(), arc.end(), [&](const ArcStep& s) { return s.x >= readable.first && seen(s); });
  const auto back =
      std::find_if(arc.rbegin(), arc.rend(), [&](const ArcStep& s) { return s.x <= readable.last && seen(s); });
  if (front != arc.end() && back != arc.rend()) readable.first = front->x, readable.last = back->x;
  std::vector<char> seen_in(static_cast<std::size_t>(readable.last - readable.first) + 1);
  const auto inside = [&](const ArcStep& s) { return s.x >= readable.first && s.x <= readable.last; };
  for (std::size_t i = 0; i < arc.size();) {
    if (!inside(arc[i]) || seen(arc[i])) {
      if (inside(arc[i])) seen_in[static_cast<std::size_t>(arc[i].x - readable.first)] = 1;
      ++i;
      continue;
    }
    std::size_t end = i;
    double worst = 0, length = 0;
    for (; end < arc.size() && inside(arc[end]) && !seen(arc[end]); ++end) {
      worst = std::max(worst, fit.Deviation(arc[end].x) / std::hypot(1.0, arc[end].slope));
      if (end > i) length += std::hypot(arc[end].x - arc[end - 1].x, arc[end].y - arc[end - 1].y);
    }
    if (worst > kMostBridge) {
      readable.gaps.emplace_back(arc[i].x, arc[end - 1].x);
    } else {
      readable.longest_bridge = std::max(readable.longest_bridge, length);
    }
    i = end;
  }
  // A gap at an end is no gap: the record starts later or ends earlier.
  while (!readable.gaps.empty() && readable.gaps.front().first < readable.first + 2) {
    readable.first = readable.gaps.front().second;
    readable.gaps.erase(readable.gaps.begin());
  }
  while (!readable.gaps.empty() && readable.gaps.back().second > readable.last - 2) {
    readable.last = readable.gaps.back().first;
    readable.gaps.pop_back();
  }
  readable.columns_read = double(std::count(seen_in.begin(), seen_in.end(), 1)) / double(seen_in.size());
  return readable;
}

void CheckReading(const Reading& reading, const std::string& name, Digitised* read) {
  RequireResolved(reading, name);
  RequireInside(reading, name);
  CheckLine(reading, name, read);
  RequireOneCurve(reading, name, read);
  CheckSmooth(reading, read);
  double left_out = 0;
  for (const auto& [a, b] : reading.readable.gaps) left_out += b - a;
  const double width = reading.readable.last - reading.readable.first;
  if (left_out > kMostLeftOut * width) {
    throw InputError(name, 0,
                     fmt::format("expected a curve that can be followed, found {:.0f} % of its width hidden or unclear",
                                 100 * left_out / width));
  }
  if (!reading.readable.gaps.empty())
    read->warnings.push_back(fmt::format(
        "{} stretch{} of the curve could not be read and {} left out, the first from {:.3g} to {:.3g} s",
        reading.readable.gaps.size(), reading.readable.gaps.size() == 1 ? "" : "es",
        reading.readable.gaps.size() == 1 ? "was" : "were", reading.page.T(reading.readable.gaps.front().first),
        reading.page.T(reading.readable.gaps.front().second)));
}

}  // namespace uiclink::digitise
