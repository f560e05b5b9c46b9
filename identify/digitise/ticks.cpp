#include "identify/digitise/ticks.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "identify/digitise/views.h"

namespace uiclink::digitise {
namespace {

/// Mean darkness of the paper beside the axis, place by place along it.
/// @param first, last  along the axis; from, to: rows across it
std::vector<double> Darkness(const cv::Mat& grey, double first, double last, int from, int to) {
  std::vector<double> darkness;
  from = std::max(from, 0), to = std::min(to, grey.rows - 1);
  for (int x = std::max(0, static_cast<int>(first) - 2); x <= std::min(grey.cols - 1, static_cast<int>(last) + 3);
       ++x) {
    double sum = 0;
    for (int y = from; y <= to; ++y) sum += 255.0 - grey.at<std::uint8_t>(y, x);
    darkness.push_back(to < from ? 0 : sum / (to - from + 1));
  }
  return darkness;
}

/// Centres of peaks that stand out of the median by half the highest one.
std::vector<double> Peaks(const std::vector<double>& darkness, double offset) {
  if (darkness.size() < 16) return {};
  std::vector<double> sorted = darkness;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
  const double usual = sorted[sorted.size() / 2];
  const double highest = *std::max_element(darkness.begin(), darkness.end()) - usual;
  std::vector<double> peaks;
  if (highest < 25) return peaks;
  for (std::size_t i = 0; i < darkness.size();) {
    double sum = 0, moment = 0;
    std::size_t k = i;
    for (; k < darkness.size() && darkness[k] - usual > 0.35 * highest; ++k)
      sum += darkness[k] - usual, moment += (darkness[k] - usual) * double(k);
    if (k > i && k - i < 9) peaks.push_back(moment / sum + offset);
    i = k + 1;
  }
  return peaks;
}

bool IsRound(double step) {
  const double power = std::pow(10, std::floor(std::log10(step) + 1e-9));
  for (const double digit : {1.0, 2.0, 2.5, 3.0, 4.0, 5.0, 10.0})
    if (std::abs(step / power - digit) < 0.03 * digit) return true;
  return false;
}

/// Peaks on an even grid: nearly all of them within 0.8 px.
Ticks EvenTicks(const std::vector<double>& peaks, double t0, double per_px) {
  Ticks ticks;
  if (peaks.size() < 4 || peaks.size() > 200) return ticks;
  const auto n = static_cast<double>(peaks.size() - 1);
  const double spacing = (peaks.back() - peaks.front()) / n;
  for (std::size_t i = 0; i < peaks.size(); ++i)
    if (std::abs(peaks[i] - peaks.front() - spacing * double(i)) > std::max(0.8, 0.02 * spacing)) return ticks;
  if (spacing < 8) return ticks;
  ticks.places = peaks;
  ticks.spacing = spacing;
  ticks.first = t0 + per_px * (per_px > 0 ? peaks.front() : peaks.back());
  ticks.step = std::abs(per_px) * spacing;
  ticks.first = ticks.step * std::round(1e3 * ticks.first / ticks.step) / 1e3 + 0.0;  // no -0.0002 for 0
  const double multiple = ticks.first / ticks.step;
  // Half a pixel, or 3 % of a step, is the reading error of a tick.
  const double error = std::max(0.03, 0.8 / spacing);
  ticks.round = IsRound(ticks.step) && std::abs(multiple - std::round(multiple)) < error;
  return ticks;
}

Ticks FindTicks(const cv::Mat& grey, double first, double last, double axis, double border, int outwards, double t0,
                double per_px) {
  const double edge = 0.5 * border + 1.5;
  for (const int way : {outwards, -outwards}) {
    const int near = static_cast<int>(std::lround(axis + way * edge)),
              far = static_cast<int>(std::lround(axis + way * (edge + 2)));
    const std::vector<double> darkness = Darkness(grey, first, last, std::min(near, far), std::max(near, far));
    std::vector<double> peaks = Peaks(darkness, std::max(0, static_cast<int>(first) - 2));
    // At the ends there are the other sides of the frame.
    std::erase_if(peaks, [&](double p) { return p < first + 3 + border || p > last - 3 - border; });
    const Ticks ticks = EvenTicks(peaks, t0, per_px);
    if (ticks.spacing > 0) return ticks;
  }
  return {};
}

cv::Mat Grey(const Page& page) {
  cv::Mat grey;
  cv::cvtColor(View(page.picture), grey, cv::COLOR_BGR2GRAY);
  return grey;
}

}  // namespace

Ticks FindTimeTicks(const Page& page) {
  if (page.border <= 0) return {};
  return FindTicks(Grey(page), page.left, page.right, page.bottom, page.border, +1, page.t0, page.t_per_px);
}

Ticks FindDisplacementTicks(const Page& page) {
  if (page.border <= 0) return {};
  const cv::Mat turned = Grey(page).t();
  return FindTicks(turned, page.top, page.bottom, page.left, page.border, -1, page.y0, page.y_per_px);
}

}  // namespace uiclink::digitise
