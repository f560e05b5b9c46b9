#include "identify/digitise/digitise.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "data/input_error.h"
#include "identify/digitise/checks.h"
#include "identify/digitise/inks.h"
#include "identify/digitise/line_fit.h"
#include "identify/digitise/ticks.h"
#include "identify/digitise/trace.h"

namespace uiclink::digitise {
namespace {

/// A colour whose ink looks like a curve.
struct Candidate {
  std::size_t ink = 0;
  InkLayer layer;
  Trace trace;
};

/// A curve covers two fifths of the width in one piece; text, ticks and legends do not.
constexpr double kLeastWidth = 0.4;
constexpr double kLeastCoverage = 0.6;  // of its reach, dashes bridged; labels of an axis stand further apart

std::vector<Candidate> FindCandidates(const Page& page, const Inks& inks) {
  std::vector<Candidate> candidates;
  const double width = page.border > 0 ? inks.x1 - inks.x0 + 1 : 0.5 * (inks.x1 - inks.x0 + 1);
  // Without a frame there are titles, too: a line of text is up to a twentieth of the page high.
  const double least_travel = page.border > 0 ? 6 + page.border : 0.05 * (inks.y1 - inks.y0);
  for (std::size_t i = 0; i < inks.inks.size(); ++i) {
    Candidate candidate{i, MakeLayer(page, inks, i), {}};
    candidate.trace = FindTrace(candidate.layer, inks);
    if (candidate.trace.strokes.size() < 16) continue;
    const double reach = candidate.trace.strokes.back().x - candidate.trace.strokes.front().x + 1;
    const int dash = std::max(20, static_cast<int>(width / 50));
    const bool long_enough = reach > kLeastWidth * width && candidate.trace.Columns() > 0.4 * reach;
    if (long_enough && Coverage(candidate.trace, dash) > kLeastCoverage && Travel(candidate.trace) > least_travel &&
        LooksDrawn(candidate.trace, HalfWidth(candidate.trace, candidate.layer)))
      candidates.push_back(std::move(candidate));
  }
  return candidates;
}

std::string ListCurves(const Inks& inks, const std::vector<Candidate>& candidates) {
  std::string list;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    list += fmt::format("{}{} {}", i == 0 ? "" : ", ", i + 1, ColourName(inks.inks[candidates[i].ink].colour));
  return list;
}

std::size_t ByColour(const std::string& text, const Inks& inks, const std::vector<Candidate>& candidates,
                     const std::string& name) {
  Colour wanted;
  try {
    wanted = ParseColour(text);
  } catch (const std::invalid_argument& error) {
    throw InputError(name, 0, error.what());
  }
  std::vector<std::pair<double, std::size_t>> distances;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    distances.emplace_back(InkDistance(wanted, inks.inks[candidates[i].ink].colour, inks.paper), i);
  std::sort(distances.begin(), distances.end());
  const bool near = distances.front().first < 0.6;
  const bool unique = distances.size() == 1 || distances[1].first > distances[0].first + 0.1;
  if (near && unique) return distances.front().second;
  throw InputError(name, 0, fmt::format("expected a {} curve, found {}", text, ListCurves(inks, candidates)));
}

Candidate ChooseCurve(const std::string& wanted, const Inks& inks, std::vector<Candidate> candidates,
                      const std::string& name) {
  if (candidates.empty())
    throw InputError(name, 0, "expected a curve that runs through the plot in one colour, found none");
  std::size_t chosen = 0;
  int number = 0;
  const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
  if (!wanted.empty() && error == std::errc() && end == wanted.data() + wanted.size()) {
    if (number < 1 || number > static_cast<int>(candidates.size()))
      throw InputError(name, 0, fmt::format("expected a curve {}, found {}", number, ListCurves(inks, candidates)));
    chosen = static_cast<std::size_t>(number) - 1;
  } else if (!wanted.empty()) {
    chosen = ByColour(wanted, inks, candidates, name);
  } else if (candidates.size() > 1) {
    throw InputError(name, 0,
                     fmt::format("expected one curve, found {}: {}; say which one with --curve COLOUR or --curve N",
                                 candidates.size(), ListCurves(inks, candidates)));
  }
  return std::move(candidates[chosen]);
}

/// Knots: sixteen in the usual swing, one to six pixels apart.
double KnotSpacing(const std::vector<double>& rows) {
  std::vector<double> turns;
  const auto [low, high] = std::minmax_element(rows.begin(), rows.end());
  const double back = std::max(2.0, 0.06 * (*high - *low));
  double extreme = rows.front(), place = 0;
  int way = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double off = rows[i] - extreme;
    if (way == 0 && std::abs(off) > back) way = off > 0 ? 1 : -1;
    if (way * off >= 0) extreme = rows[i], place = double(i);
    if (way * off < -back) turns.push_back(place), way = -way, extreme = rows[i], place = double(i);
  }
  if (turns.size() < 3) return 4;
  std::vector<double> halves;
  for (std::size_t i = 1; i < turns.size(); ++i) halves.push_back(turns[i] - turns[i - 1]);
  const auto middle = halves.begin() + static_cast<std::ptrdiff_t>(halves.size() / 2);
  std::nth_element(halves.begin(), middle, halves.end());
  return std::clamp(*middle / 8, 1.0, 6.0);
}

/// The next of 1, 2, 2.5, 4, 5 times a power of ten from `least` on.
double RoundRate(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double digit : {1.0, 2.0, 2.5, 4.0, 5.0})
    if (digit * power >= least * (1 - 1e-9)) return digit * power;
  return 10 * power;
}

/// Samples at multiples of 1/rate between the first and the last column that was read.
void Sample(const Page& page, const LineFit& fit, const Readability& readable, double rate_hz, Digitised* read) {
  const double spacing_s = fit.curve.spacing() * page.t_per_px;
  read->rate_hz = rate_hz > 0 ? rate_hz : RoundRate(5 / spacing_s);
  const double first = page.T(readable.first), last = page.T(readable.last);
  const auto from = static_cast<long>(std::ceil(first * read->rate_hz - 1e-6));
  const auto to = static_cast<long>(std::floor(last * read->rate_hz + 1e-6));
  for (long k = from; k <= to; ++k) {
    const double t = double(k) / read->rate_hz;
    const double x = (t - page.t0) / page.t_per_px;
    if (readable.InGap(x)) continue;
    read->t.push_back(t);
    read->y.push_back(page.Y(fit.curve(x)));
    read->uncertainty.push_back(std::abs(page.y_per_px) * fit.Deviation(x));
  }
  for (const auto& [a, b] : readable.gaps) read->gaps.emplace_back(page.T(a), page.T(b));
}

void CheckTicks(const Page& page, Digitised* read) {
  if (page.border <= 0) return;
  const auto judge = [&](const Ticks& ticks, const char* axis) {
    if (ticks.spacing <= 0) {
      read->notes.push_back(fmt::format("no even ticks found on the {} axis: its range is not checked", axis));
      return;
    }
    read->notes.push_back(fmt::format("{} ticks on the {} axis, every {:.4g} from {:.4g}", ticks.places.size(), axis,
                                      ticks.step, ticks.first));
    if (!ticks.round)
      read->warnings.push_back(
          fmt::format("the {} axis has ticks at {:.4g}, {:.4g}, ..., no round numbers: is its range right?", axis,
                      ticks.first, ticks.first + ticks.step));
  };
  judge(FindTimeTicks(page), "time");
  judge(FindDisplacementTicks(page), "displacement");
}

Page FindPage(const Picture& light, const std::string& name, const DigitiseOptions& options, Digitised* read) {
  if (!options.points.empty()) return MakePage(light, options.points, name);
  if (!options.time || !options.displacement)
    throw InputError(name, 0,
                     "expected what the axes show: --x-range and --y-range (the values at the frame's sides), or two "
                     "or more --point PX,PY=T,Y");
  const Frame frame = FindFrame(light, name);
  read->frame = frame.corners;
  return MakePage(light, frame, *options.time, *options.displacement, name);
}

/// The frame in the picture, with forty places a side.
std::vector<Pixel> Outline(const Page& page) {
  std::vector<Pixel> outline;
  if (page.border <= 0) return outline;
  const std::array<Pixel, 5> corners{Pixel{page.left, page.top}, Pixel{page.right, page.top},
                                     Pixel{page.right, page.bottom}, Pixel{page.left, page.bottom},
                                     Pixel{page.left, page.top}};
  for (std::size_t side = 0; side < 4; ++side)
    for (int i = 0; i <= 40; ++i) {
      const Pixel &a = corners[side], &b = corners[side + 1];
      outline.push_back(page.to_picture({a.x + (b.x - a.x) * i / 40, a.y + (b.y - a.y) * i / 40}));
    }
  return outline;
}

}  // namespace

Digitised Digitise(const Picture& picture, const std::string& name, const DigitiseOptions& options) {
  Digitised read;
  const Picture light = WithEvenPaper(WithLightPaper(picture));
  const Page page = FindPage(light, name, options, &read);
  const Inks inks = FindInks(page);
  const Candidate curve = ChooseCurve(options.curve, inks, FindCandidates(page, inks), name);
  const std::vector<double> start = RollDisc(curve.trace, HalfWidth(curve.trace, curve.layer), inks.x0, inks.x1);
  const LineFit fit = FitLine(curve.layer, inks, curve.trace, start, KnotSpacing(start));
  read.colour = ColourName(inks.inks[curve.ink].colour);
  read.line_width_px = fit.profile.width, read.blur_px = fit.profile.blur;
  read.y_per_px = std::abs(page.y_per_px), read.s_per_px = page.t_per_px;
  read.frame_closure_px = page.scale_residual, read.tilt_deg = page.tilt * 57.29578, read.bow_px = page.bow;
  const Readability readable = FindReadable(fit, curve.trace);
  CheckReading({page, inks, curve.layer, curve.trace, fit, readable}, name, &read);
  Sample(page, fit, readable, options.rate_hz, &read);
  CheckTicks(page, &read);
  read.outline = Outline(page);
  for (const ArcStep& step : fit.arc) {
    if (step.x < readable.first || step.x > readable.last || readable.InGap(step.x)) continue;
    read.trail.emplace_back(page.to_picture({step.x, step.y}), step.known && step.inked);
  }
  return read;
}

}  // namespace uiclink::digitise
