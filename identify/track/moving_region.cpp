#include "identify/track/moving_region.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "data/input_error.h"
#include "identify/track/coarse_search.h"
#include "identify/track/film.h"

namespace uiclink::track {
namespace {

constexpr int kWidest = 320;      // of the pictures that are searched [pixel]
constexpr int kPatch = 12;        // of a scout [reduced pixel]
constexpr int kCell = 10;         // one scout at most in each [reduced pixel]
constexpr double kAlike = 0.15;   // of its own motion that a scout may move against its region
constexpr int kLargestBox = 128;  // [pixel]

/// A small patch that is looked for in picture after picture.
class Scout {
 public:
  Scout(const GrayView& first, const Box& box, int turn) : places{box.Centre()}, search_(first, box), turn_(turn) {}

  /// Those that stand still, or are covered, are looked for in every third picture alone, in turns.
  void Look(const GrayView& picture, int number) {
    const std::size_t n = places.size();
    const Point last = places.back(), step = n > 1 ? last - places[n - 2] : Point{};
    places.push_back(last);
    if ((still_ >= kStillFrom || misses_ >= kStillFrom) && (number + turn_) % kEveryThird != 0) return;
    const bool moves = still_ < kStillFrom && misses_ == 0 && n > 1;
    const double radius = moves ? kNear + std::hypot(step.x, step.y) : kWide * std::min(2, 1 + misses_);
    const std::optional<Lookalikes> found = search_.Find(picture, moves ? last + step : last, radius);
    ++looks_;
    if (!found || found->best.score < kLeastScore) {
      still_ = 0;
      ++all_misses_, ++misses_;
      return;
    }
    misses_ = 0;
    places.back() = found->best.place;
    const Point moved = places.back() - last;
    still_ = std::hypot(moved.x, moved.y) < 0.5 ? still_ + 1 : 0;
  }

  /// Something else came before it, or it has changed.
  bool IsLost() const { return all_misses_ > 6 + looks_ / 4; }

  std::vector<Point> places;  ///< one a picture; where it was not looked for or not found, the one before

 private:
  static constexpr int kEveryThird = 3;
  static constexpr int kStillFrom = 4;
  static constexpr double kNear = 4, kWide = 8;  // [reduced pixel]
  static constexpr double kLeastScore = 0.65;    // blur and the neighbourhood take their share

  CoarseSearch search_;
  int turn_;
  int still_ = 0, misses_ = 0, all_misses_ = 0, looks_ = 0;
};

/// A scout at the strongest texture of every cell.
std::vector<Scout> SendScouts(const cv::Mat& picture) {
  cv::Mat strength, mean;
  cv::cornerMinEigenVal(picture, strength, 5);
  cv::boxFilter(strength, mean, CV_32F, {kPatch, kPatch}, {0, 0});  // at the corner of each patch
  double strongest = 0;
  cv::minMaxLoc(mean, nullptr, &strongest);
  const GrayView view{picture.data, picture.cols, picture.rows, static_cast<std::ptrdiff_t>(picture.step[0])};
  std::vector<Scout> scouts;
  for (int y = 1; y + kCell + kPatch < picture.rows; y += kCell) {
    for (int x = 1; x + kCell + kPatch < picture.cols; x += kCell) {
      double best = 0;
      cv::Point at;
      cv::minMaxLoc(mean(cv::Rect(x, y, kCell, kCell)), nullptr, &best, nullptr, &at);
      if (best < 0.02 * strongest) continue;
      scouts.emplace_back(view, Box{x + at.x, y + at.y, kPatch, kPatch}, static_cast<int>(scouts.size()));
    }
  }
  return scouts;
}

/// What one scout saw, the camera's motion taken off.
struct Motion {
  const Scout* scout = nullptr;
  std::vector<Point> way;  // about its mean
  Point axis;              // unit vector of its largest motion
  double rms = 0;          // along the axis
  double swing = 0;
  int turns = 0;
  bool smooth = false;  // no jumps from picture to picture
};

/// Reversals of a motion by more than a quarter of its swing.
int CountTurns(const std::vector<Point>& way, Point axis, double swing) {
  int turns = 0;
  double low = Dot(way.front(), axis), high = low;
  int heading = 0;
  for (const Point& p : way) {
    const double at = Dot(p, axis);
    low = std::min(low, at), high = std::max(high, at);
    const bool fell = high - at > 0.5 * swing && heading >= 0, rose = at - low > 0.5 * swing && heading <= 0;
    if (!fell && !rose) continue;
    if (heading != 0) ++turns;
    heading = fell ? -1 : 1;
    low = high = at;
  }
  return turns;
}

Motion Describe(const Scout& scout, const std::vector<Point>& camera) {
  Motion motion{.scout = &scout, .way = {}, .axis = {}};
  Point mean;
  for (std::size_t i = 0; i < scout.places.size(); ++i) {
    motion.way.push_back(scout.places[i] - scout.places[0] - camera[i]);
    mean = mean + motion.way.back();
  }
  mean = (1.0 / static_cast<double>(motion.way.size())) * mean;
  double xx = 0, xy = 0, yy = 0;
  for (Point& p : motion.way) {
    p = p - mean;
    xx += p.x * p.x, xy += p.x * p.y, yy += p.y * p.y;
  }
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
  motion.axis = {std::cos(angle), std::sin(angle)};
  const double largest = 0.5 * (xx + yy) + std::hypot(0.5 * (xx - yy), xy);
  motion.rms = std::sqrt(largest / static_cast<double>(motion.way.size()));
  double low = 0, high = 0;
  for (const Point& p : motion.way)
    low = std::min(low, Dot(p, motion.axis)), high = std::max(high, Dot(p, motion.axis));
  motion.swing = 0.5 * (high - low);
  motion.turns = CountTurns(motion.way, motion.axis, motion.swing);
  double bends = 0;
  for (std::size_t i = 2; i < motion.way.size(); ++i) {
    const Point bend = motion.way[i] - 2 * motion.way[i - 1] + motion.way[i - 2];
    bends += Dot(bend, bend);
  }
  // (w dt)^2 for an oscillation; 0.25 for four steps from one end to the other. Half a pixel is the scouts' own error.
  motion.smooth = std::sqrt(bends / static_cast<double>(motion.way.size())) < 0.25 * motion.rms + 0.5;
  return motion;
}

/// The camera's way: the median of the quieter half of all points, picture by picture.
std::vector<Point> CalcCamera(const std::vector<Scout>& scouts) {
  const std::size_t pictures = scouts.front().places.size();
  const std::vector<Point> none(pictures);
  std::vector<std::pair<double, const Scout*>> by_motion;
  for (const Scout& scout : scouts) by_motion.emplace_back(Describe(scout, none).rms, &scout);
  std::sort(by_motion.begin(), by_motion.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  by_motion.resize((by_motion.size() + 1) / 2);
  std::vector<Point> camera;
  std::vector<double> x(by_motion.size()), y(by_motion.size());
  for (std::size_t i = 0; i < pictures; ++i) {
    for (std::size_t j = 0; j < by_motion.size(); ++j) {
      const Point moved = by_motion[j].second->places[i] - by_motion[j].second->places[0];
      x[j] = moved.x, y[j] = moved.y;
    }
    const auto middle = static_cast<std::ptrdiff_t>(x.size() / 2);
    std::nth_element(x.begin(), x.begin() + middle, x.end());
    std::nth_element(y.begin(), y.begin() + middle, y.end());
    camera.push_back({x[static_cast<std::size_t>(middle)], y[static_cast<std::size_t>(middle)]});
  }
  return camera;
}

/// Do two scouts sit on one stiff body? Median of their difference against their own motion: a scout that is led astray
/// for some pictures comes back.
bool MoveTogether(const Motion& a, const Motion& b) {
  std::vector<double> apart(a.way.size());
  for (std::size_t i = 0; i < a.way.size(); ++i) {
    const Point d = (a.scout->places[i] - a.scout->places[0]) - (b.scout->places[i] - b.scout->places[0]);
    apart[i] = std::hypot(d.x, d.y);
  }
  const auto middle = apart.begin() + static_cast<std::ptrdiff_t>(apart.size() / 2);
  std::nth_element(apart.begin(), middle, apart.end());
  return *middle < kAlike * std::min(a.rms, b.rms) + 0.5;
}

struct Group {
  std::vector<const Motion*> members;
  double swing = 0;  // median of the members
};

/// Groups of scouts that saw the same motion, the widest swing first.
std::vector<Group> FindGroups(double smallest_swing, std::vector<Motion>* motions) {
  std::sort(motions->begin(), motions->end(), [](const Motion& a, const Motion& b) { return a.swing > b.swing; });
  std::vector<char> taken(motions->size(), 0);
  std::vector<Group> groups;
  for (std::size_t i = 0; i < motions->size(); ++i) {
    const Motion& seed = (*motions)[i];
    if (taken[i] != 0 || !seed.smooth || seed.turns < kTurns || seed.swing < smallest_swing) continue;
    Group group;
    for (std::size_t j = i; j < motions->size(); ++j) {
      const Motion& other = (*motions)[j];
      if (taken[j] != 0 || other.swing < 0.5 * seed.swing || !MoveTogether(seed, other)) continue;
      taken[j] = 1;
      group.members.push_back(&(*motions)[j]);
    }
    group.swing = group.members[group.members.size() / 2]->swing;
    groups.push_back(std::move(group));
  }
  // A few scouts that were led astray together are no region.
  std::size_t largest = 0;
  for (const Group& group : groups) largest = std::max(largest, group.members.size());
  std::erase_if(groups, [=](const Group& group) { return 4 * group.members.size() < largest; });
  std::stable_sort(groups.begin(), groups.end(), [](const Group& a, const Group& b) { return a.swing > b.swing; });
  return groups;
}

/// The scouts' patches of the largest part of a group that hangs together, as a box of the full picture.
Box BoxOf(const Group& group, double factor, const Box& picture) {
  std::vector<cv::Point2d> places;
  for (const Motion* m : group.members) places.emplace_back(m->scout->places[0].x, m->scout->places[0].y);
  std::vector<int> labels;
  const int parts = cv::partition(places, labels, [](cv::Point2d a, cv::Point2d b) {
    return std::max(std::abs(a.x - b.x), std::abs(a.y - b.y)) < 2.5 * kCell;
  });
  std::vector<int> sizes(static_cast<std::size_t>(parts), 0);
  for (const int label : labels) ++sizes[static_cast<std::size_t>(label)];
  const auto largest = static_cast<int>(std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
  // A scout at the rim sits half on the background: of each its middle half counts.
  constexpr double kHalf = 0.25 * kPatch;
  double left = 1e9, top = 1e9, right = -1e9, bottom = -1e9;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (labels[i] != largest) continue;
    left = std::min(left, places[i].x - kHalf), right = std::max(right, places[i].x + kHalf);
    top = std::min(top, places[i].y - kHalf), bottom = std::max(bottom, places[i].y + kHalf);
  }
  const auto scaled = [factor](double v) { return static_cast<int>(std::lround(factor * v)); };
  Box box{scaled(left), scaled(top), scaled(right - left), scaled(bottom - top)};
  if (box.width > kLargestBox) box.x += (box.width - kLargestBox) / 2, box.width = kLargestBox;
  if (box.height > kLargestBox) box.y += (box.height - kLargestBox) / 2, box.height = kLargestBox;
  constexpr int kLeastBox = 24;  // [pixel]
  box = Grown(box, std::max({0, (kLeastBox - box.width + 1) / 2, (kLeastBox - box.height + 1) / 2}));
  const Box inner = Grown(picture, -5);
  const int end_x = std::min(box.x + box.width, inner.x + inner.width);
  const int end_y = std::min(box.y + box.height, inner.y + inner.height);
  box.x = std::max(box.x, inner.x), box.y = std::max(box.y, inner.y);
  box.width = end_x - box.x, box.height = end_y - box.y;
  return box;
}

/// What swings less than the camera itself cannot be told from it.
double SmallestSwing(const std::vector<Point>& camera, double factor) {
  double low_x = 0, high_x = 0, low_y = 0, high_y = 0;
  for (const Point& p : camera) {
    low_x = std::min(low_x, p.x), high_x = std::max(high_x, p.x);
    low_y = std::min(low_y, p.y), high_y = std::max(high_y, p.y);
  }
  return std::max(kSmallestSwing / factor, 0.5 * std::hypot(high_x - low_x, high_y - low_y));
}

MovingRegion Choose(const std::vector<Group>& groups, double factor, const Box& picture, const std::string& file) {
  const auto region = [&](const Group& group) {
    return MovingRegion{.box = BoxOf(group, factor, picture),
                        .swing = factor * group.swing,
                        .patches = static_cast<int>(group.members.size())};
  };
  if (groups.empty()) {
    throw InputError(file, 0,
                     fmt::format("expected something that swings by more than {:g} pixels, found nothing; say where "
                                 "it is with --roi X,Y,W,H",
                                 kSmallestSwing));
  }
  const MovingRegion best = region(groups.front());
  for (std::size_t i = 1; i < groups.size(); ++i) {
    if (groups[i].swing < kEquallyStrong * groups.front().swing) break;
    const MovingRegion rival = region(groups[i]);
    const auto text = [](const MovingRegion& r) {
      return fmt::format("{},{},{},{} (+-{:.0f} pixels)", r.box.x, r.box.y, r.box.width, r.box.height, r.swing);
    };
    throw InputError(file, 0,
                     fmt::format("expected one region that swings most, found two that move differently: {} and {}; "
                                 "choose one with --roi X,Y,W,H",
                                 text(best), text(rival)));
  }
  return best;
}

std::vector<Motion> DescribeAll(const std::vector<Scout>& scouts) {
  const std::vector<Point> camera = CalcCamera(scouts);
  std::vector<Motion> motions;
  for (const Scout& scout : scouts) motions.push_back(Describe(scout, camera));
  return motions;
}

bool IsDecided(const std::vector<Motion>& motions) {
  double widest = 0;
  int turns = 0;
  for (const Motion& m : motions)
    if (m.smooth && m.swing > widest && m.turns >= 1) widest = m.swing, turns = m.turns;
  return widest >= kSmallestSwing && turns >= kTurns;
}

}  // namespace

MovingRegion FindMovingRegion(const std::filesystem::path& film, const std::function<void(int)>& progress) {
  FilmReader reader(film);
  if (!reader.Next()) throw InputError(film.string(), 0, "expected a film, found no picture in it");
  const double factor = std::max(1.0, static_cast<double>(reader.width()) / kWidest);
  const auto reduced = [&] {
    const GrayView gray = reader.gray();
    const cv::Mat view(gray.height, gray.width, CV_8U, const_cast<std::uint8_t*>(gray.data),
                       static_cast<std::size_t>(gray.stride));
    cv::Mat small;
    cv::resize(view, small, {}, 1 / factor, 1 / factor, factor > 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
    return small;
  };
  std::vector<Scout> scouts = SendScouts(reduced());
  constexpr int kBetweenLooks = 10;
  for (int i = 1; i < kLongest && !scouts.empty() && reader.Next(); ++i) {
    if (progress) progress(i);
    const cv::Mat picture = reduced();
    const GrayView view{picture.data, picture.cols, picture.rows, static_cast<std::ptrdiff_t>(picture.step[0])};
    for (Scout& scout : scouts) scout.Look(view, i);
    std::erase_if(scouts, [](const Scout& scout) { return scout.IsLost(); });
    if (i % kBetweenLooks == 0 && !scouts.empty() && IsDecided(DescribeAll(scouts))) break;
  }
  std::vector<Motion> motions;
  double smallest = 0;
  if (!scouts.empty()) motions = DescribeAll(scouts), smallest = SmallestSwing(CalcCamera(scouts), factor);
  return Choose(FindGroups(smallest, &motions), factor, reader.gray().Bounds(), film.string());
}

}  // namespace uiclink::track
