#include "identify/track/coarse_search.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace uiclink::track {

struct CoarseSearch::Patch {
  int factor = 1;
  Point centre;  // of the reduced patch, from its first pixel [pixel]
  cv::Mat reduced;
};

namespace {

cv::Mat View(const GrayView& picture) {
  return {picture.height, picture.width, CV_8U, const_cast<std::uint8_t*>(picture.data),
          static_cast<std::size_t>(picture.stride)};
}

cv::Mat Reduce(const cv::Mat& part, int factor) {
  cv::Mat reduced;
  if (factor == 1) return part;
  cv::resize(part, reduced, {part.cols / factor, part.rows / factor}, 0, 0, cv::INTER_AREA);
  return reduced;
}

/// The top of the parabola through three values about the middle one, from -0.5 to 0.5.
double Top(float before, float at, float after) {
  const double bend = static_cast<double>(before) - 2.0 * static_cast<double>(at) + static_cast<double>(after);
  return bend < 0 ? std::clamp(0.5 * static_cast<double>(before - after) / bend, -0.5, 0.5) : 0;
}

/// Normalised cross-correlation, as cv::matchTemplate(TM_CCOEFF_NORMED) has it; its Fourier transforms take several
/// times as long for patches and windows as small as most here.
cv::Mat CorrelateDirectly(const cv::Mat& window, const cv::Mat& patch) {
  cv::Mat reference, picture, map(window.rows - patch.rows + 1, window.cols - patch.cols + 1, CV_32F);
  patch.convertTo(reference, CV_32F, 1, -cv::mean(patch)[0]);
  window.convertTo(picture, CV_32F, 1, -cv::mean(window)[0]);
  const double norm = reference.dot(reference), n = static_cast<double>(patch.total());
  const auto width = static_cast<std::size_t>(picture.cols), places = static_cast<std::size_t>(map.cols);
  std::vector<float> cross(places), sum(width), squares(width);
  for (int y = 0; y < map.rows; ++y) {
    for (std::vector<float>* row : {&cross, &sum, &squares}) std::fill(row->begin(), row->end(), 0.0f);
    for (int j = 0; j < patch.rows; ++j) {
      const float* const r = reference.ptr<float>(j);
      const float* const p = picture.ptr<float>(y + j);
      for (int i = 0; i < patch.cols; ++i)
        for (std::size_t x = 0; x < places; ++x) cross[x] += r[i] * p[x + static_cast<std::size_t>(i)];
      for (std::size_t x = 0; x < width; ++x) sum[x] += p[x], squares[x] += p[x] * p[x];
    }
    for (std::size_t x = 0; x < places; ++x) {
      const auto end = static_cast<std::ptrdiff_t>(x) + patch.cols, begin = static_cast<std::ptrdiff_t>(x);
      const double all = std::accumulate(sum.begin() + begin, sum.begin() + end, 0.0);
      const double spread =
          norm * (std::accumulate(squares.begin() + begin, squares.begin() + end, 0.0) - all * all / n);
      map.at<float>(y, static_cast<int>(x)) =
          spread > 0 ? static_cast<float>(static_cast<double>(cross[x]) / std::sqrt(spread)) : 0.0f;
    }
  }
  return map;
}

cv::Mat Correlate(const cv::Mat& window, const cv::Mat& patch) {
  constexpr std::size_t kSmall = 2'000'000;  // products, from where the transforms are faster
  const auto places =
      static_cast<std::size_t>(window.rows - patch.rows + 1) * static_cast<std::size_t>(window.cols - patch.cols + 1);
  if (places * patch.total() < kSmall) return CorrelateDirectly(window, patch);
  cv::Mat map;
  cv::matchTemplate(window, patch, map, cv::TM_CCOEFF_NORMED);
  cv::patchNaNs(map, -1);
  return map;
}

/// The highest place of a map, refined; the map's own pixels.
Lookalike Highest(const cv::Mat& map) {
  double score = 0;
  cv::Point at;
  cv::minMaxLoc(map, nullptr, &score, nullptr, &at);
  Lookalike found{.place = {static_cast<double>(at.x), static_cast<double>(at.y)}, .score = score};
  const float middle = map.at<float>(at);
  if (at.x > 0 && at.x + 1 < map.cols)
    found.place.x += Top(map.at<float>(at.y, at.x - 1), middle, map.at<float>(at.y, at.x + 1));
  if (at.y > 0 && at.y + 1 < map.rows)
    found.place.y += Top(map.at<float>(at.y - 1, at.x), middle, map.at<float>(at.y + 1, at.x));
  return found;
}

/// Takes the peak about `top` out of the map: everything that falls steadily from it.
void RemovePeak(cv::Point top, cv::Mat* map) {
  std::vector<cv::Point> open{top};
  cv::Mat seen = cv::Mat::zeros(map->size(), CV_8U);
  seen.at<std::uint8_t>(top) = 1;
  while (!open.empty()) {
    const cv::Point p = open.back();
    open.pop_back();
    const float height = map->at<float>(p);
    for (int k = 0; k < 9; ++k) {
      const cv::Point q(p.x + k % 3 - 1, p.y + k / 3 - 1);
      if (q.x < 0 || q.y < 0 || q.x >= map->cols || q.y >= map->rows || seen.at<std::uint8_t>(q) != 0) continue;
      if (map->at<float>(q) > height) continue;
      seen.at<std::uint8_t>(q) = 1;
      open.push_back(q);
    }
  }
  map->setTo(-1.0f, seen);
}

}  // namespace

CoarseSearch::CoarseSearch(const GrayView& reference, const Box& box) : patch_(std::make_unique<Patch>()) {
  patch_->factor = std::max(1, std::min(box.width, box.height) / kReduced);
  const int width = box.width / patch_->factor * patch_->factor, height = box.height / patch_->factor * patch_->factor;
  const int x = box.x + (box.width - width) / 2, y = box.y + (box.height - height) / 2;
  patch_->centre = box.Centre() - Point{static_cast<double>(x), static_cast<double>(y)};
  patch_->reduced = Reduce(View(reference)(cv::Rect(x, y, width, height)), patch_->factor).clone();
}

CoarseSearch::~CoarseSearch() = default;
CoarseSearch::CoarseSearch(CoarseSearch&&) noexcept = default;
CoarseSearch& CoarseSearch::operator=(CoarseSearch&&) noexcept = default;

std::optional<Lookalikes> CoarseSearch::Find(const GrayView& picture, Point around, double radius) const {
  const int factor = patch_->factor;
  const Point corner = around - patch_->centre;
  const auto low = [&](double place) { return std::max(0, static_cast<int>(std::floor(place - radius))); };
  const int left = low(corner.x), top = low(corner.y);
  const auto size = [&](double place, int first, int patch, int whole) {
    const int last = std::min(whole, static_cast<int>(std::ceil(place + radius)) + patch * factor);
    return (last - first) / factor * factor;
  };
  const int width = size(corner.x, left, patch_->reduced.cols, picture.width);
  const int height = size(corner.y, top, patch_->reduced.rows, picture.height);
  if (width < patch_->reduced.cols * factor || height < patch_->reduced.rows * factor) return std::nullopt;
  cv::Mat map = Correlate(Reduce(View(picture)(cv::Rect(left, top, width, height)), factor), patch_->reduced);
  const auto in_picture = [&](Lookalike found) {
    found.place = static_cast<double>(factor) * found.place +
                  Point{static_cast<double>(left), static_cast<double>(top)} + patch_->centre;
    return found;
  };
  const Lookalike best = Highest(map);
  Lookalikes lookalikes{.best = in_picture(best), .rival = std::nullopt};
  RemovePeak({static_cast<int>(std::lround(best.place.x)), static_cast<int>(std::lround(best.place.y))}, &map);
  const Lookalike rival = Highest(map);
  if (rival.score > -1) lookalikes.rival = in_picture(rival);
  return lookalikes;
}

}  // namespace uiclink::track
