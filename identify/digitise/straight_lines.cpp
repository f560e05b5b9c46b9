#include "identify/digitise/straight_lines.h"

#include <algorithm>
#include <cmath>

namespace uiclink::digitise {
namespace {

constexpr int kParts = 24;

/// Ink in each part of each row (rows: the direction of the lines that are looked for).
struct Counts {
  int rows = 0;
  std::vector<int> ink;  ///< row by row, kParts each
  std::vector<int> size;

  int At(int row, int part) const { return ink[std::size_t(row) * kParts + std::size_t(part)]; }
};

double MedianAround(const Counts& counts, int row, int part) {
  std::vector<int> around;
  for (int off = 4; off <= 10; ++off)
    for (const int r : {row - off, row + off})
      if (r >= 0 && r < counts.rows) around.push_back(counts.At(r, part));
  if (around.empty()) return 0;
  const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
  std::nth_element(around.begin(), middle, around.end());
  return *middle;
}

std::vector<int> FindRows(const Counts& counts, double share) {
  std::vector<int> found;
  for (int row = 0; row < counts.rows; ++row) {
    int parts = 0, more = 0;
    for (int part = 0; part < kParts; ++part) {
      const double usual = MedianAround(counts, row, part), room = counts.size[std::size_t(part)] - usual;
      if (room < 0.25 * counts.size[std::size_t(part)]) continue;
      ++parts;
      more += counts.At(row, part) - usual >= std::max(2.0, 0.18 * room);
    }
    if (parts >= kParts / 3 && more >= share * parts) found.push_back(row);
  }
  // The soft edges of a line belong to it.
  std::vector<int> wide;
  for (const int row : found)
    for (int r = row - 1; r <= row + 1; ++r)
      if (r >= 0 && r < counts.rows && (wide.empty() || wide.back() < r)) wide.push_back(r);
  return wide;
}

}  // namespace

void FindStraightLines(const Page& page, Inks* inks) {
  const int width = inks->x1 - inks->x0 + 1, height = inks->y1 - inks->y0 + 1;
  Counts rows{height, std::vector<int>(std::size_t(height) * kParts), std::vector<int>(kParts)};
  Counts columns{width, std::vector<int>(std::size_t(width) * kParts), std::vector<int>(kParts)};
  for (int x = 0; x < width; ++x) ++rows.size[std::size_t(x * kParts / width)];
  for (int y = 0; y < height; ++y) ++columns.size[std::size_t(y * kParts / height)];
  const double faintest = std::max(12.0, 4 * inks->noise);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::uint8_t* p = page.picture.At(inks->x0 + x, inks->y0 + y);
      const double off =
          std::max({std::abs(p[0] - inks->paper[0]), std::abs(p[1] - inks->paper[1]), std::abs(p[2] - inks->paper[2])});
      if (off < faintest) continue;
      ++rows.ink[std::size_t(y) * kParts + std::size_t(x * kParts / width)];
      ++columns.ink[std::size_t(x) * kParts + std::size_t(y * kParts / height)];
    }
  }
  const double share = page.border > 0 ? 0.8 : 0.5;
  for (const int row : FindRows(rows, share)) inks->level_lines.push_back(inks->y0 + row);
  for (const int column : FindRows(columns, share)) inks->upright_lines.push_back(inks->x0 + column);
}

}  // namespace uiclink::digitise
