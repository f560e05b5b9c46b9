#include "identify/track/background.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "identify/track/patch_tracker.h"

namespace uiclink::track {
namespace {

constexpr int kPatch = 33;      // [pixel]
constexpr double kTexture = 6;  // least rms slope along the worse direction [grey levels/pixel], weakest that helps
constexpr double kWorthwhile = 0.15;  // of the strongest texture there is

struct Candidate {
  Box box;
  double texture = 0;
};

/// rms slope of a box along its weaker direction [grey levels/pixel].
double CalcTexture(const cv::Mat& dx, const cv::Mat& dy, const Box& box) {
  const cv::Rect part(box.x, box.y, box.width, box.height);
  const cv::Mat x = dx(part), y = dy(part);
  const double xx = x.dot(x), xy = x.dot(y), yy = y.dot(y), n = static_cast<double>(box.width) * box.height;
  const double least = 0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy);
  return std::sqrt(std::max(0.0, least) / n);
}

std::vector<Candidate> FindCandidates(const GrayView& reference, const Box& where, const std::vector<Box>& avoid) {
  const cv::Mat picture(reference.height, reference.width, CV_8U, const_cast<std::uint8_t*>(reference.data),
                        static_cast<std::size_t>(reference.stride));
  cv::Mat smooth, dx, dy;
  cv::GaussianBlur(picture, smooth, {7, 7}, 1.5);
  cv::Sobel(smooth, dx, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(smooth, dy, CV_32F, 0, 1, 3, 0.125);
  const int patch = std::min({kPatch, where.width, where.height});
  std::vector<Candidate> candidates;
  for (int y = where.y; y + patch <= where.y + where.height; y += std::max(1, patch / 2)) {
    for (int x = where.x; x + patch <= where.x + where.width; x += std::max(1, patch / 2)) {
      const Box box{x, y, patch, patch};
      if (std::any_of(avoid.begin(), avoid.end(), [&](const Box& other) { return box.Overlaps(other); })) continue;
      candidates.push_back({box, CalcTexture(dx, dy, box)});
    }
  }
  return candidates;
}

}  // namespace

std::vector<Box> ChooseBackground(const GrayView& reference, const std::optional<Box>& within,
                                  const std::vector<Box>& avoid, int most) {
  constexpr int kMargin = 16;  // for the camera's own motion [pixel]
  const Box inner = Grown(reference.Bounds(), within ? -PatchTracker::kBorder : -kMargin);
  std::vector<Candidate> candidates = FindCandidates(reference, within.value_or(inner), avoid);
  std::erase_if(candidates, [&](const Candidate& c) { return !inner.Contains(c.box); });
  double strongest = 0;
  for (const Candidate& c : candidates) strongest = std::max(strongest, c.texture);
  // Noise alone makes slopes of less than a grey level.
  const double least = std::max(within ? 0.5 : 0.2 * kTexture, kWorthwhile * strongest);
  std::erase_if(candidates, [&](const Candidate& c) { return c.texture < least; });
  // One after the other, the place that is farthest from all chosen ones, strong texture counting as distance.
  std::vector<Box> chosen;
  while (static_cast<int>(chosen.size()) < most && !candidates.empty()) {
    const auto worth = [&](const Candidate& c) {
      double nearest = std::hypot(reference.width, reference.height);
      for (const Box& box : chosen)
        nearest = std::min(nearest, std::hypot(box.Centre().x - c.box.Centre().x, box.Centre().y - c.box.Centre().y));
      return nearest * std::sqrt(c.texture);
    };
    const auto best = std::max_element(candidates.begin(), candidates.end(),
                                       [&](const Candidate& a, const Candidate& b) { return worth(a) < worth(b); });
    chosen.push_back(best->box);
    std::erase_if(candidates, [&](const Candidate& c) { return c.box.Overlaps(chosen.back()); });
  }
  return chosen;
}

}  // namespace uiclink::track
