#include "identify/digitise/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "data/file.h"
#include "data/input_error.h"
#include "identify/digitise/views.h"

namespace uiclink::digitise {
namespace {

constexpr int kSmallest = 64;
constexpr double kLargest = 100e6;  // a page of A4 at 1000 dots per inch

/// Transparent parts on white; one, three or four channels of eight bits become three.
cv::Mat OnWhite(const cv::Mat& read) {
  cv::Mat eight;
  read.convertTo(eight, CV_8U, read.depth() == CV_16U ? 1.0 / 257 : 1.0);
  cv::Mat bgr;
  if (eight.channels() == 1) cv::cvtColor(eight, bgr, cv::COLOR_GRAY2BGR);
  if (eight.channels() == 3) bgr = eight;
  if (eight.channels() != 4) return bgr;
  bgr.create(eight.size(), CV_8UC3);
  for (int y = 0; y < eight.rows; ++y) {
    for (int x = 0; x < eight.cols; ++x) {
      const auto& p = eight.at<cv::Vec4b>(y, x);
      for (int c = 0; c < 3; ++c)
        bgr.at<cv::Vec3b>(y, x)[c] = static_cast<std::uint8_t>((p[c] * p[3] + 255 * (255 - p[3]) + 127) / 255);
    }
  }
  return bgr;
}

/// The ten terms of a cubic surface over [-1, 1]^2.
std::array<double, 10> CubicTerms(double x, double y) {
  return {1, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y};
}

struct Block {
  double x, y;  ///< centre, over [-1, 1]^2
  std::array<double, 3> bright;
};

/// The 90 % quantile of each channel in blocks of the picture: paper, unless more than nine tenths are ink.
std::vector<Block> BrightBlocks(const Picture& picture) {
  constexpr int kBlocks = 24;
  std::vector<Block> blocks;
  for (int by = 0; by < kBlocks; ++by) {
    for (int bx = 0; bx < kBlocks; ++bx) {
      const int x0 = bx * picture.width / kBlocks, x1 = (bx + 1) * picture.width / kBlocks;
      const int y0 = by * picture.height / kBlocks, y1 = (by + 1) * picture.height / kBlocks;
      Block block{(x0 + x1) / double(picture.width) - 1, (y0 + y1) / double(picture.height) - 1, {}};
      for (std::size_t c = 0; c < 3; ++c) {
        std::vector<std::uint8_t> values;
        for (int y = y0; y < y1; ++y)
          for (int x = x0; x < x1; ++x) values.push_back(picture.At(x, y)[c]);
        const auto rank = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 9 / 10);
        std::nth_element(values.begin(), rank, values.end());
        block.bright[c] = *rank;
      }
      blocks.push_back(block);
    }
  }
  return blocks;
}

/// Least squares in which blocks that are darker than the surface (ink, a table under the page) lose their weight.
std::array<double, 10> FitSurface(const std::vector<Block>& blocks, std::size_t channel) {
  cv::Mat coefficients = cv::Mat::zeros(10, 1, CV_64F);
  for (int pass = 0; pass < 8; ++pass) {
    cv::Mat normal = 1e-9 * cv::Mat::eye(10, 10, CV_64F), right = cv::Mat::zeros(10, 1, CV_64F);
    for (const Block& block : blocks) {
      const std::array<double, 10> terms = CubicTerms(block.x, block.y);
      const cv::Mat row(1, 10, CV_64F, const_cast<double*>(terms.data()));
      const double off = pass == 0 ? 0 : block.bright[channel] - row.dot(coefficients.t());
      const double weight = off > -4 ? 1 : std::pow(4 / -off, 3);
      normal += weight * row.t() * row;
      right += weight * block.bright[channel] * row.t();
    }
    cv::solve(normal, right, coefficients, cv::DECOMP_CHOLESKY);
  }
  std::array<double, 10> surface;
  for (int i = 0; i < 10; ++i) surface[static_cast<std::size_t>(i)] = coefficients.at<double>(i);
  return surface;
}

double Evaluate(const std::array<double, 10>& surface, double x, double y) {
  const std::array<double, 10> terms = CubicTerms(x, y);
  double sum = 0;
  for (std::size_t i = 0; i < terms.size(); ++i) sum += surface[i] * terms[i];
  return sum;
}

}  // namespace

Picture ReadPicture(const std::filesystem::path& path) {
  const std::string file = path.string();
  const std::string bytes = ReadFileWhole(path);
  cv::Mat read;
  try {
    const cv::Mat raw(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
    if (!bytes.empty()) read = cv::imdecode(raw, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    read.release();
  }
  if (read.empty() || (read.depth() != CV_8U && read.depth() != CV_16U) || read.channels() == 2)
    throw InputError(file, 0, "expected a picture (PNG, JPEG, TIFF, BMP, WebP), found none; export or scan the plot");
  if (read.cols < kSmallest || read.rows < kSmallest || double(read.cols) * read.rows > kLargest)
    throw InputError(file, 0,
                     fmt::format("expected a picture from {0}x{0} pixels to 100 million, found {1}x{2}", kSmallest,
                                 read.cols, read.rows));
  return ToPicture(OnWhite(read));
}

Picture WithLightPaper(Picture picture) {
  cv::Mat grey, small;
  cv::cvtColor(View(picture), grey, cv::COLOR_BGR2GRAY);
  cv::resize(grey, small, {}, 0.25, 0.25, cv::INTER_NEAREST);
  std::vector<std::uint8_t> values(small.begin<std::uint8_t>(), small.end<std::uint8_t>());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (*middle < 100)
    for (std::uint8_t& value : picture.bgr) value = static_cast<std::uint8_t>(255 - value);
  return picture;
}

Picture WithEvenPaper(Picture picture) {
  const std::vector<Block> blocks = BrightBlocks(picture);
  const std::array surfaces{FitSurface(blocks, 0), FitSurface(blocks, 1), FitSurface(blocks, 2)};
  double unevenness = 0;
  for (const auto& surface : surfaces) {
    double low = 1e9, high = 1;
    for (const Block& block : blocks) {
      const double paper = Evaluate(surface, block.x, block.y);
      low = std::min(low, paper);
      high = std::max(high, paper);
    }
    unevenness = std::max(unevenness, (high - low) / high);
  }
  if (unevenness < 0.03) return picture;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double paper = Evaluate(surfaces[c], 2.0 * x / picture.width - 1, 2.0 * y / picture.height - 1);
        std::uint8_t& value = picture.bgr[3 * (std::size_t(y) * std::size_t(picture.width) + std::size_t(x)) + c];
        value = cv::saturate_cast<std::uint8_t>(value * 245 / std::max(paper, 20.0));
      }
    }
  }
  return picture;
}

void WritePicture(const std::filesystem::path& path, const Picture& picture) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", View(picture), bytes);
  WriteFileWhole(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace uiclink::digitise
