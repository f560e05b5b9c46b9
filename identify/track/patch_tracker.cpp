#include "identify/track/patch_tracker.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace uiclink::track {
namespace {

using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;
using Column = Eigen::ArrayXf;

constexpr int kBlock = 8;  // of the covariance, and the transform blocks of the usual codecs [pixel]
// Smoothing correlates neighbours; what crosses the blocks' borders is missing from their sums: 0.1 of the variance in
// each direction, for neighbours that correlate by exp(-d^2 / (4 0.8^2)).
constexpr double kAcrossBorders = 1.22;
constexpr double kInterpolation = 0.004;  // error of the interpolation along each axis, measured [pixel]
constexpr double kStill = 1e-3;           // a step that ends the iteration [pixel]
constexpr int kWeighed = 4;               // iterations that renew the weights; afterwards the problem is linear
constexpr float kWeightScale = 4;         // of w_i, in standard deviations
constexpr float kLeastScale = 0.25f;      // of the residual: rounding to whole grey levels, smoothed [grey levels]
constexpr double kLeastContrast = 0.1;    // of the reference's

/// A part of a picture, smoothed.
class Window {
 public:
  Window(const GrayView& picture, const Box& part) : part_(part) {
    const cv::Mat whole(picture.height, picture.width, CV_8U, const_cast<std::uint8_t*>(picture.data),
                        static_cast<std::size_t>(picture.stride));
    cv::Mat grey;
    whole(cv::Rect(part.x, part.y, part.width, part.height)).convertTo(grey, CV_32F);
    constexpr int kTaps = 7;  // 3.75 standard deviations on both sides
    cv::GaussianBlur(grey, grey_, {kTaps, kTaps}, PatchTracker::kSmoothing, PatchTracker::kSmoothing,
                     cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
  }

  float At(int x, int y) const { return grey_.ptr<float>(y - part_.y)[x - part_.x]; }

  /// Keys' cubic between the pixels. The place must be kBorder / 2 pixels within the part.
  float Sample(float x, float y) const {
    const float left = std::floor(x), top = std::floor(y);
    const Eigen::Array4f wx = Weights(x - left), wy = Weights(y - top);
    const float* row = grey_.ptr<float>(static_cast<int>(top) - 1 - part_.y) + static_cast<int>(left) - 1 - part_.x;
    const std::size_t stride = grey_.step1();
    using Four = Eigen::Map<const Eigen::Array4f>;
    const Eigen::Array4f column = wy(0) * Four(row) + wy(1) * Four(row + stride) + wy(2) * Four(row + 2 * stride) +
                                  wy(3) * Four(row + 3 * stride);
    return (wx * column).sum();
  }

  /// The same on a grid of whole steps from (x, y), row after row: first along y, then along x.
  void SampleGrid(float x, float y, int columns, int rows, Column* values) const {
    const float left = std::floor(x), top = std::floor(y);
    const Eigen::Array4f wx = Weights(x - left), wy = Weights(y - top);
    const float* corner = grey_.ptr<float>(static_cast<int>(top) - 1 - part_.y) + static_cast<int>(left) - 1 - part_.x;
    const std::size_t stride = grey_.step1();
    Column between(columns + 3);
    using Row = Eigen::Map<const Column>;
    for (int j = 0; j < rows; ++j, corner += stride) {
      between = wy(0) * Row(corner, columns + 3) + wy(1) * Row(corner + stride, columns + 3) +
                wy(2) * Row(corner + 2 * stride, columns + 3) + wy(3) * Row(corner + 3 * stride, columns + 3);
      values->segment(j * columns, columns) = wx(0) * between.head(columns) + wx(1) * between.segment(1, columns) +
                                              wx(2) * between.segment(2, columns) + wx(3) * between.tail(columns);
    }
  }

 private:
  /// Of the four neighbours, at a part of a pixel.
  static Eigen::Array4f Weights(float s) {
    return {((-0.5f * s + 1) * s - 0.5f) * s, (1.5f * s - 2.5f) * s * s + 1, ((-1.5f * s + 2) * s + 0.5f) * s,
            (0.5f * s - 0.5f) * s * s};
  }

  Box part_;
  cv::Mat grey_;
};

/// Standard deviation of noise from the median of its absolute values: a scale that outliers do not move. Of large
/// patches every second, third, ... value is enough.
float RobustScale(const Column& values) {
  const Eigen::Index stride = 1 + values.size() / 1000;
  std::vector<float> some;
  for (Eigen::Index i = 0; i < values.size(); i += stride) some.push_back(std::abs(values(i)));
  const auto middle = some.begin() + static_cast<std::ptrdiff_t>(some.size() / 2);
  std::nth_element(some.begin(), middle, some.end());
  return 1.4826f * *middle;
}

struct Solution {
  Vector5 q = Vector5::Zero();  // contrast, brightness, contrast times the step in x, y, angle
  Matrix5 inverse = Matrix5::Zero();
};

}  // namespace

struct PatchTracker::Pixels {
  Column x, y;                                 // from the centre
  Eigen::Matrix<float, Eigen::Dynamic, 5> by;  // value about its mean, 1, derivatives by x, y and angle
  std::vector<int> block;
  int blocks = 0;
  bool grid = false;  // all pixels of the box, row after row
  int columns = 0, rows = 0;

  Pixels(const GrayView& reference, const Box& box, int step);
  Eigen::Index size() const { return x.size(); }
};

PatchTracker::Pixels::Pixels(const GrayView& reference, const Box& box, int step)
    : grid(step == 1), columns((box.width + step - 1) / step), rows((box.height + step - 1) / step) {
  const Window window(reference, Grown(box, kBorder));
  const Point centre = box.Centre();
  const int blocks_across = (box.width + kBlock - 1) / kBlock;
  blocks = blocks_across * ((box.height + kBlock - 1) / kBlock);
  const Eigen::Index n = static_cast<Eigen::Index>(columns) * rows;
  x.resize(n), y.resize(n), by.resize(n, 5);
  Eigen::Index i = 0;
  for (int v = box.y; v < box.y + box.height; v += step) {
    for (int u = box.x; u < box.x + box.width; u += step, ++i) {
      x(i) = static_cast<float>(u - centre.x), y(i) = static_cast<float>(v - centre.y);
      const float gx = 0.5f * (window.At(u + 1, v) - window.At(u - 1, v));
      const float gy = 0.5f * (window.At(u, v + 1) - window.At(u, v - 1));
      by.row(i) << window.At(u, v), 1.0f, gx, gy, gy * x(i) - gx * y(i);
      block.push_back((v - box.y) / kBlock * blocks_across + (u - box.x) / kBlock);
    }
  }
  by.col(0).array() -= by.col(0).mean();
}

PatchTracker::PatchTracker(const GrayView& reference, const Box& box, const Options& options)
    : box_(box), options_(options), reach_(0.5 * std::hypot(box.width, box.height)) {
  if (box.width < kSmallest || box.height < kSmallest || !Grown(reference.Bounds(), -kBorder).Contains(box))
    throw std::invalid_argument("PatchTracker: box must be 12 pixels wide and high, and 4 within the picture");
  const double area = static_cast<double>(box.width) * box.height;
  pixels_ =
      std::make_shared<Pixels>(reference, box, static_cast<int>(std::ceil(std::sqrt(area / options.most_pixels))));
  const Eigen::Matrix2d information =
      (pixels_->by.middleCols<2>(2).transpose() * pixels_->by.middleCols<2>(2)).cast<double>();
  const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(information).eigenvalues()(0);
  pixels_per_grey_level_ = least > 0 ? 1 / std::sqrt(least) : std::numeric_limits<double>::infinity();
  // A round marker has no angle. Where the angle would be known much worse than the place it is left at 0.
  const auto turn = static_cast<double>(pixels_->by.col(4).squaredNorm());
  constexpr double kWorse = 5;
  options_.turns &= turn > 0 && reach_ / std::sqrt(turn) < kWorse * pixels_per_grey_level_;
}

namespace {

/// One search in one picture: samples, weights, steps.
template <typename Pixels>
class Search {
 public:
  Search(const Pixels& pixels, bool turns, const Window& window)
      : pixels_(pixels),
        turns_(turns),
        window_(window),
        values_(pixels.size()),
        weights_(Column::Ones(pixels.size())),
        weighted_(pixels.size(), 6) {}

  void SampleAt(Point place, double angle) {
    const auto x0 = static_cast<float>(place.x), y0 = static_cast<float>(place.y);
    if (pixels_.grid && angle == 0) {
      window_.SampleGrid(x0 + pixels_.x(0), y0 + pixels_.y(0), pixels_.columns, pixels_.rows, &values_);
      return;
    }
    const auto c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
    for (Eigen::Index i = 0; i < pixels_.size(); ++i) {
      const float x = pixels_.x(i), y = pixels_.y(i);
      values_(i) = window_.Sample(x0 + c * x - s * y, y0 + s * x + c * y);
    }
  }

  /// Weighted least squares of the sampled values on the reference and its derivatives.
  std::optional<Solution> Solve() {
    mean_ = values_.mean();  // near zero, single precision has digits to spare
    weighted_.template leftCols<5>() = pixels_.by.array().colwise() * weights_;
    weighted_.col(5) = (values_ - mean_) * weights_;
    Matrix5 normal = (weighted_.template leftCols<5>().transpose() * pixels_.by).template cast<double>();
    Vector5 right = (pixels_.by.transpose() * weighted_.col(5)).template cast<double>();
    if (!turns_) normal.row(4).setZero(), normal.col(4).setZero(), normal(4, 4) = 1, right(4) = 0;
    const Eigen::LDLT<Matrix5> factors(normal);
    const double largest = factors.vectorD().maxCoeff();
    if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 1e-9 * largest)) return std::nullopt;
    Solution solution{.q = factors.solve(right), .inverse = factors.solve(Matrix5::Identity())};
    if (!turns_) solution.inverse.row(4).setZero(), solution.inverse.col(4).setZero();
    return solution;
  }

  Column Residuals(const Solution& solution) const {
    return values_ - mean_ - (pixels_.by * solution.q.template cast<float>()).array();
  }

  void Weigh(const Solution& solution) {
    const Column residuals = Residuals(solution);
    const float scale = kWeightScale * std::max(RobustScale(residuals), kLeastScale);
    weights_ = (1 + (residuals / scale).square()).square().inverse();
  }

  const Column& weights() const { return weights_; }

  /// Correlation of the sampled values with the reference, all pixels alike.
  double CalcScore() const {
    const Column about_mean = values_ - values_.mean();
    const double spread =
        static_cast<double>(about_mean.square().sum()) * static_cast<double>(pixels_.by.col(0).squaredNorm());
    return spread > 0 ? static_cast<double>(about_mean.matrix().dot(pixels_.by.col(0))) / std::sqrt(spread) : 0;
  }

 private:
  const Pixels& pixels_;
  bool turns_;
  const Window& window_;
  Column values_, weights_;
  float mean_ = 0;
  Eigen::Matrix<float, Eigen::Dynamic, 6> weighted_;
};

/// Covariance of the step (block-wise), residual and share of inliers.
template <typename Pixels>
void Judge(const Pixels& pixels, const Search<Pixels>& search, const Solution& solution, PatchFit* fit) {
  const Column residuals = search.Residuals(solution), pulls = search.weights() * residuals;
  std::vector<Vector5> scores(static_cast<std::size_t>(pixels.blocks), Vector5::Zero());
  for (Eigen::Index i = 0; i < pixels.size(); ++i)
    scores[static_cast<std::size_t>(pixels.block[static_cast<std::size_t>(i)])] +=
        (pulls(i) * pixels.by.row(i)).transpose().template cast<double>();
  Matrix5 spread = Matrix5::Zero();
  for (const Vector5& s : scores) spread += s * s.transpose();
  const double few = pixels.blocks > 5 ? static_cast<double>(pixels.blocks) / (pixels.blocks - 5) : 6.0;  // 5 unknowns
  const Matrix5 covariance = kAcrossBorders * few * solution.inverse * spread * solution.inverse;
  const double gain = solution.q(0), angle = fit->angle;
  Eigen::Matrix2d turn;
  turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  const Eigen::Matrix2d place = turn * covariance.block<2, 2>(2, 2) * turn.transpose() / (gain * gain);
  constexpr double kFloor = kInterpolation * kInterpolation;
  fit->covariance = {place(0, 0) + kFloor, place(0, 1), place(1, 1) + kFloor};
  fit->gain = gain;
  fit->residual = std::sqrt(static_cast<double>((pulls * residuals).sum() / search.weights().sum()));
  fit->inliers = static_cast<double>(search.weights().mean());
  fit->score = search.CalcScore();
}

}  // namespace

std::optional<PatchFit> PatchTracker::Find(const GrayView& picture, Point start, double angle) const {
  constexpr int kReach = 8;  // how far the iteration may go from its start before the window ends [pixel]
  const int half = static_cast<int>(std::ceil(options_.turns ? reach_ : 0.5 * std::max(box_.width, box_.height)));
  const int extent = half + kReach + kBorder;
  const int cx = static_cast<int>(std::lround(start.x)), cy = static_cast<int>(std::lround(start.y));
  const int left = std::max(0, cx - extent), top = std::max(0, cy - extent);
  const int right = std::min(picture.width, cx + extent + 1), bottom = std::min(picture.height, cy + extent + 1);
  if (right - left < kSmallest || bottom - top < kSmallest) return std::nullopt;
  const Box part{left, top, right - left, bottom - top};
  const auto inside = [&](Point place, double turned) {
    const double c = std::abs(std::cos(turned)), s = std::abs(std::sin(turned)), margin = 0.5 * kBorder;
    const double w = 0.5 * (c * box_.width + s * box_.height), h = 0.5 * (s * box_.width + c * box_.height);
    return place.x - w > part.x + margin && place.x + w < part.x + part.width - 1 - margin &&
           place.y - h > part.y + margin && place.y + h < part.y + part.height - 1 - margin;
  };
  const Window window(picture, part);
  Search<Pixels> search(*pixels_, options_.turns, window);
  PatchFit fit{.place = start, .angle = angle};
  for (int i = 0; i < options_.most_iterations; ++i) {
    if (!inside(fit.place, fit.angle)) return std::nullopt;
    search.SampleAt(fit.place, fit.angle);
    std::optional<Solution> solution = search.Solve();
    if (!solution || !(solution->q(0) > kLeastContrast)) return std::nullopt;
    if (i < kWeighed) search.Weigh(*solution);
    const double gain = solution->q(0), dx = solution->q(2) / gain, dy = solution->q(3) / gain;
    const double c = std::cos(fit.angle), s = std::sin(fit.angle), da = solution->q(4) / gain;
    const double step = std::max(std::hypot(dx, dy), std::abs(da) * reach_);
    if (step < kStill) Judge(*pixels_, search, *solution, &fit);
    const double shorten = std::min(1.0, 2.0 / step);  // the linear model holds over about the smoothing
    fit.place = fit.place - shorten * Point{c * dx - s * dy, s * dx + c * dy};
    fit.angle -= shorten * da;
    if (step < kStill) return fit;
  }
  return std::nullopt;
}

}  // namespace uiclink::track
