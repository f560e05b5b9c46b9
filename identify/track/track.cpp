#include "identify/track/track.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "data/input_error.h"
#include "identify/track/background.h"
#include "identify/track/film.h"
#include "identify/track/finish.h"
#include "identify/track/target.h"

namespace uiclink::track {
namespace {

constexpr double kLeastTexture = 0.25;  // worst standard deviation for noise of one grey level [pixel]
constexpr int kBackgroundPatches = 8;
constexpr int kScaleLooks = 40;  // pictures in which the tag's corners are found for the scale

void CheckOptions(const TrackOptions& options) {
  const auto require_positive = [](const std::optional<double>& value, const char* name) {
    if (value && !(*value > 0 && std::isfinite(*value)))
      throw std::invalid_argument(fmt::format("TrackFilm: {} = {}, must be a number above 0", name, *value));
  };
  require_positive(options.mm_per_pixel, "mm_per_pixel");
  require_positive(options.tag_mm, "tag_mm");
  require_positive(options.rate_hz, "rate_hz");
  if (options.mm_per_pixel.has_value() == options.tag_mm.has_value())
    throw std::invalid_argument("TrackFilm: needs either mm_per_pixel or tag_mm");
  if (options.roi && options.tag) throw std::invalid_argument("TrackFilm: needs either roi or tag, not both");
  if (options.tag_mm && !options.tag && !options.roi) throw std::invalid_argument("TrackFilm: tag_mm needs tag or roi");
}

/// One target through the film.
struct Course {
  Target target;
  Follower follower;
  std::vector<Sighting> sightings = {};
};

/// The one pass over the film.
class Pass {
 public:
  Pass(const std::filesystem::path& film, const TrackOptions& options) : film_(film), options_(options), reader_(film) {
    if (!reader_.Next()) throw InputError(film.string(), 0, "expected a film, found no picture in it");
    const GrayView first = reader_.gray();
    for (const Target& target : FindTargets(film, first, options)) AddTarget(first, target);
    if (!options.no_background) AddBackground(first);
  }

  FilmObservations Run() {
    const auto expected = static_cast<int>(reader_.count().value_or(0));
    int done = 0;
    do {
      Look(reader_.gray());
      if (options_.progress && ++done % 10 == 0)
        options_.progress("following the patch", done, std::max(done + 1, expected));
    } while (reader_.Next());
    if (out_.stamps.size() < 2) throw InputError(film_.string(), 0, "expected a film, found a single picture");
    Course& course = courses_[ChooseCourse()];
    out_.file = film_.string();
    out_.width = reader_.width(), out_.height = reader_.height();
    out_.roi = course.target.box;
    if (course.target.tag) out_.tag_id = course.target.tag->id;
    out_.shutter = course.follower.shutter();
    out_.sightings = std::move(course.sightings);
    return std::move(out_);
  }

 private:
  void AddTarget(const GrayView& first, const Target& target) {
    Course course{target, Follower(first, target.box, {.patch = {}, .swings = true})};
    if (!(course.follower.tracker().PixelsPerGreyLevel() < kLeastTexture)) {
      const Box& box = target.box;
      throw InputError(
          film_.string(), 0,
          fmt::format("expected a patch with texture in both directions at {},{},{},{}, found one that "
                      "noise of one grey level moves by {:.2g} pixels; choose another with --roi",
                      box.x, box.y, box.width, box.height, course.follower.tracker().PixelsPerGreyLevel()));
    }
    courses_.push_back(std::move(course));
  }

  void AddBackground(const GrayView& first) {
    std::vector<Box> avoid;
    for (const Course& course : courses_) avoid.push_back(Grown(course.target.box, 8));
    const int most = kBackgroundPatches;
    for (const Box& box : ChooseBackground(first, options_.background, avoid, most)) {
      background_.emplace_back(first, box,
                               Follower::Options{.patch = {.turns = false, .most_pixels = 1200}, .swings = false});
      out_.background.push_back({.box = box, .sightings = {}});
    }
  }

  void Look(const GrayView& picture) {
    out_.stamps.push_back(reader_.stamp());
    for (Course& course : courses_) course.sightings.push_back(course.follower.Follow(picture));
    for (std::size_t i = 0; i < background_.size(); ++i)
      out_.background[i].sightings.push_back(background_[i].Follow(picture));
    if (options_.tag_mm) LookForScale(picture);
  }

  /// Corners of the tag, now and then: the mean of many is steadier than one.
  void LookForScale(const GrayView& picture) {
    const std::size_t n = out_.stamps.size();
    if ((n > 20 && n % 20 != 0) || static_cast<int>(out_.scale_tags.size()) >= kScaleLooks) return;
    const Course& course = courses_.front();
    const Sighting& sighting = course.sightings.back();
    const bool own = course.target.tag && courses_.size() == 1 && sighting.fit;
    if (course.target.tag && !own && courses_.size() == 1) return;
    // Near the followed tag, if there is but one: looking through whole pictures is slow.
    Box part = picture.Bounds();
    if (own) {
      const Box& box = course.target.box;
      const Point corner = sighting.fit->place - Point{0.5 * box.width, 0.5 * box.height};
      const Box near = Grown({static_cast<int>(corner.x), static_cast<int>(corner.y), box.width, box.height}, 12);
      if (!part.Contains(near)) return;
      part = near;
    }
    const GrayView view{picture.data + part.y * picture.stride + part.x, part.width, part.height, picture.stride};
    for (const Tag& tag : FindTags(view)) out_.scale_tags.push_back(tag);
  }

  /// Of several tags the one that swings most.
  std::size_t ChooseCourse() const {
    std::vector<double> swings;
    for (const Course& course : courses_) swings.push_back(CalcMotionRms(course.sightings));
    const auto widest = std::max_element(swings.begin(), swings.end()) - swings.begin();
    for (std::size_t i = 0; i < swings.size(); ++i) {
      if (static_cast<std::ptrdiff_t>(i) == widest ||
          swings[i] < kEquallyFar * swings[static_cast<std::size_t>(widest)])
        continue;
      throw InputError(
          film_.string(), 0,
          fmt::format("expected one tag that swings most, found the tags {} and {}; choose one with "
                      "--tag-id",
                      courses_[static_cast<std::size_t>(widest)].target.tag->id, courses_[i].target.tag->id));
    }
    return static_cast<std::size_t>(widest);
  }

  static constexpr double kEquallyFar = 0.7;

  std::filesystem::path film_;
  const TrackOptions& options_;
  FilmReader reader_;
  std::vector<Course> courses_;
  std::vector<Follower> background_;
  FilmObservations out_;
};

}  // namespace

TrackResult TrackFilm(const std::filesystem::path& film, const TrackOptions& options) {
  CheckOptions(options);
  return FinishTrack(Pass(film, options).Run(), options);
}

}  // namespace uiclink::track
