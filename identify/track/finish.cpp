#include "identify/track/finish.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "data/input_error.h"
#include "identify/track/order.h"
#include "identify/upper_median.h"

namespace uiclink::track {
namespace {

constexpr std::size_t kFewestSamples = 16;  // as ReadRecord wants them
constexpr double kMostLeftOut = 0.5;        // share of the pictures
constexpr double kMostHidden = 0.02;        // jumps of time, share of the pictures
constexpr double kMuchAcross = 0.2;         // motion across the axis worth a word
constexpr double kMostAcross = 0.5;         // of a patch that was found without help, and below:
constexpr double kMostLost = 0.1;           // share of the pictures
constexpr double kLeastMedianScore = 0.7;   // correlation
constexpr double kTilted = 0.02;            // sides of a tag that differ so much
constexpr double kUnsteady = 0.5;           // disagreement of the background [pixel]
constexpr double kFollows = 0.7;            // correlation of background and target
constexpr double kFollowsShare = 0.02;      // of the target's motion

/// A picture's place in the reference picture.
struct Steadied {
  std::size_t picture = 0;
  Point place;
  PlaceCovariance covariance;
};

std::string Percent(double share) { return fmt::format("{:.2g} %", 100 * share); }

/// Builds the result step by step.
class Finisher {
 public:
  Finisher(const FilmObservations& seen, const TrackOptions& options) : seen_(seen), options_(options) {
    result_.file = seen.file;
    result_.width = seen.width, result_.height = seen.height;
    result_.pictures = seen.sightings.size();
    result_.roi = seen.roi;
    result_.tag_id = seen.tag_id;
    result_.shutter = seen.shutter;
  }

  TrackResult Finish() {
    TakeTimes();
    TakePlaces();
    TakeAxis();
    DoubtOwnChoice();
    TakeScale();
    JudgeOrder();
    FillSamples();
    JudgeBackground();
    SayLeftOut();
    std::sort(result_.left_out.begin(), result_.left_out.end(),
              [](const LeftOutPicture& a, const LeftOutPicture& b) { return a.picture < b.picture; });
    return std::move(result_);
  }

 private:
  [[noreturn]] void Refuse(const std::string& message) const { throw InputError(seen_.file, 0, message); }
  void LeaveOut(std::size_t picture, LeftOut why) { result_.left_out.push_back({picture, why}); }

  void TakeTimes() {
    result_.times = JudgeTimes(seen_.stamps, options_.rate_hz);
    const auto n = static_cast<double>(result_.pictures);
    if (10 * result_.times.backwards > static_cast<int>(result_.pictures) ||
        std::count(result_.times.t.begin(), result_.times.t.end(), std::nullopt) > static_cast<std::ptrdiff_t>(n / 2)) {
      Refuse(
          fmt::format("expected time stamps that increase, found {} of {} that do not and {} pictures without one; "
                      "give the camera's rate with --rate HZ",
                      result_.times.backwards, result_.pictures,
                      std::count(result_.times.t.begin(), result_.times.t.end(), std::nullopt)));
    }
    for (const std::string& notice : result_.times.notices) result_.notices.push_back(notice);
    for (const Gap& gap : result_.times.gaps) result_.missing += gap.pictures.value_or(1);
  }

  void TakePlaces() {
    const double rms = CalcMotionRms(seen_.sightings);
    const Point lever = seen_.roi.Centre();
    if (!seen_.background.empty()) result_.camera = FitCamera(seen_.background, rms, lever);
    std::vector<double> scores;
    for (std::size_t i = 0; i < result_.pictures; ++i) {
      const Sighting& sighting = seen_.sightings[i];
      if (!sighting.fit) {
        LeaveOut(i, sighting.why);
        continue;
      }
      PlaceCovariance covariance = sighting.fit->covariance;
      const std::optional<Point> place = result_.camera.ToReference(i, sighting.fit->place, &covariance);
      if (!place || !result_.times.t[i]) {
        LeaveOut(i, place ? LeftOut::kNoTimeStamp : LeftOut::kNoStill);
        continue;
      }
      scores.push_back(sighting.fit->score);
      places_.push_back({i, *place, covariance});
    }
    if (places_.size() < kFewestSamples ||
        static_cast<double>(result_.left_out.size()) > kMostLeftOut * static_cast<double>(result_.pictures))
      RefuseFew();
    result_.median_score = UpperMedian(scores);
  }

  [[noreturn]] void RefuseFew() const {
    std::string message =
        fmt::format("expected the patch in most of the {} pictures, found it in {}", result_.pictures, places_.size());
    const auto count = [&](LeftOut why) {
      return std::count_if(result_.left_out.begin(), result_.left_out.end(),
                           [why](const LeftOutPicture& left) { return left.why == why; });
    };
    for (const LeftOut why : {LeftOut::kLost, LeftOut::kEdge, LeftOut::kAmbiguous, LeftOut::kNoStill})
      if (count(why) > 0) message += fmt::format("; in {} {}", count(why), Reason(why));
    Refuse(message + "; choose another patch with --roi X,Y,W,H");
  }

  void TakeAxis() {
    Point mean;
    for (const Steadied& s : places_) mean = mean + s.place;
    mean = (1.0 / static_cast<double>(places_.size())) * mean;
    double xx = 0, xy = 0, yy = 0;
    for (const Steadied& s : places_) {
      const Point d = s.place - mean;
      xx += d.x * d.x, xy += d.x * d.y, yy += d.y * d.y;
    }
    if (options_.axis == Axis::kX) result_.axis = {1, 0};
    if (options_.axis == Axis::kY) result_.axis = {0, -1};
    if (options_.axis == Axis::kPrincipal) {
      const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
      Point axis{std::cos(angle), std::sin(angle)};
      if (std::abs(axis.x) >= std::abs(axis.y) ? axis.x < 0 : axis.y > 0) axis = -1.0 * axis;
      result_.axis = axis;
    }
    const PlaceCovariance motion{xx, xy, yy};
    const double along = motion.Along(result_.axis), across = motion.Along({-result_.axis.y, result_.axis.x});
    if (!(along > 0)) Refuse("expected a patch that moves, found one that stands still in all pictures");
    result_.cross_share = std::sqrt(std::max(0.0, across) / along);
    if (result_.cross_share > kMuchAcross) {
      result_.warnings.push_back(
          fmt::format("the patch also moves across the axis, by {} of its motion along it; is the camera level, is "
                      "--axis right?",
                      Percent(result_.cross_share)));
    }
  }

  /// A patch that nobody pointed at must speak for itself.
  void DoubtOwnChoice() const {
    if (options_.roi || options_.tag) return;
    const double left_out = static_cast<double>(result_.left_out.size()) / static_cast<double>(result_.pictures);
    if (result_.cross_share < kMostAcross && left_out < kMostLost && result_.median_score > kLeastMedianScore) return;
    Refuse(
        fmt::format("expected one patch that swings along a line, found {},{},{},{}, which does not look like one "
                    "({} of the pictures left out, {} of the motion across the line, correlation {:.2f}); say where "
                    "it is with --roi X,Y,W,H",
                    seen_.roi.x, seen_.roi.y, seen_.roi.width, seen_.roi.height, Percent(left_out),
                    Percent(result_.cross_share), result_.median_score));
  }

  void TakeScale() {
    if (options_.mm_per_pixel) {
      result_.mm_per_pixel = *options_.mm_per_pixel;
      return;
    }
    std::vector<double> scales, tilts;
    for (const Tag& tag : seen_.scale_tags) {
      if (tag.id != options_.tag_id.value_or(seen_.tag_id.value_or(tag.id))) continue;
      const TagScale scale = CalcTagScale(tag, *options_.tag_mm, result_.axis);
      scales.push_back(scale.mm_per_pixel), tilts.push_back(scale.tilt);
    }
    if (scales.empty()) Refuse("expected a tag for the scale (--tag-mm), found none; or give --mm-per-pixel");
    result_.mm_per_pixel = UpperMedian(scales);
    double squares = 0;
    for (const double s : scales) squares += (s - result_.mm_per_pixel) * (s - result_.mm_per_pixel);
    const auto n = static_cast<double>(scales.size());
    result_.scale_error = std::sqrt(squares / n / std::max(1.0, n - 1)) / result_.mm_per_pixel;
    if (UpperMedian(tilts) > kTilted) {
      result_.warnings.push_back(fmt::format(
          "the tag's sides differ by {}: the camera looks at it from the side, and the scale holds at the tag alone",
          Percent(UpperMedian(tilts))));
    }
  }

  MotionSeries Series() const {
    MotionSeries series;
    for (const Steadied& s : places_) {
      series.t.push_back(*result_.times.t[s.picture]);
      series.x.push_back(Dot(s.place, result_.axis));
      series.sigma.push_back(std::sqrt(s.covariance.Along(result_.axis)));
    }
    return series;
  }

  /// Pictures that are repeated, and those that are missing without a trace in the time stamps.
  void JudgeOrder() {
    const std::vector<std::size_t> repeated = FindRepeated(Series());
    for (const std::size_t i : repeated) LeaveOut(places_[i].picture, LeftOut::kRepeated);
    for (auto i = repeated.rbegin(); i != repeated.rend(); ++i)
      places_.erase(places_.begin() + static_cast<std::ptrdiff_t>(*i));
    if (!result_.times.even) return;  // nobody can say how much time is missing
    const std::vector<HiddenGap> gaps = FindHiddenGaps(Series(), result_.times.step);
    if (static_cast<double>(gaps.size()) > std::max(2.0, kMostHidden * static_cast<double>(result_.pictures))) {
      Refuse(
          fmt::format("expected pictures at even times, found {} jumps of the motion as if pictures were missing; "
                      "the film's time stamps cannot be trusted, record it anew without dropped pictures",
                      gaps.size()));
    }
    for (const HiddenGap& gap : gaps) CloseGap(gap);
  }

  void CloseGap(const HiddenGap& gap) {
    const std::size_t first = places_[gap.at].picture;
    const double shift = gap.pictures * result_.times.step;
    result_.warnings.push_back(fmt::format(
        "at {:.4g} s the motion jumps as if {} picture{} {}, though the time stamps go on evenly: all later times are "
        "moved by {:.4g} ms",
        *result_.times.t[first], std::abs(gap.pictures), std::abs(gap.pictures) == 1 ? "" : "s",
        gap.pictures > 0 ? "were missing" : "too many were there", 1e3 * shift));
    result_.missing += std::max(0, gap.pictures);
    if (gap.pictures > 0) result_.times.gaps.push_back({first - 1, gap.pictures});
    for (std::size_t i = first; i < result_.pictures; ++i)
      if (result_.times.t[i]) *result_.times.t[i] += shift;
  }

  void FillSamples() {
    const double metres = 1e-3 * result_.mm_per_pixel;
    const Point zero = places_.front().place;
    const std::vector<double> excess = CalcExcessScatter(Series());
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const Steadied& s = places_[i];
      result_.t.push_back(*result_.times.t[s.picture]);
      result_.y.push_back(metres * Dot(s.place - zero, result_.axis));
      result_.uncertainty.push_back(metres * std::hypot(std::sqrt(s.covariance.Along(result_.axis)), excess[i]));
      result_.picture.push_back(s.picture);
      result_.places.push_back(seen_.sightings[s.picture].fit->place);
    }
    result_.shutter_loss = CalcShutterLoss();
  }

  /// 1 - sin(x)/x, x = w tau / 2, at the median half swing; the shutter open all the time where nothing is known of it.
  double CalcShutterLoss() const {
    const auto [low, high] = std::minmax_element(result_.y.begin(), result_.y.end());
    const double middle = 0.5 * (*low + *high);
    std::vector<double> crossings;
    for (std::size_t i = 1; i < result_.y.size(); ++i)
      if ((result_.y[i] > middle) != (result_.y[i - 1] > middle)) crossings.push_back(result_.t[i]);
    if (crossings.size() < 3) return 0;
    std::vector<double> halves;
    for (std::size_t i = 1; i < crossings.size(); ++i) halves.push_back(crossings[i] - crossings[i - 1]);
    const double open = result_.shutter.value_or(1.0) * result_.times.step;
    const double x = 0.5 * std::numbers::pi / UpperMedian(halves) * open;
    return x > 0 ? 1 - std::sin(x) / x : 0;
  }

  void JudgeBackground() {
    const CameraMotion& camera = result_.camera;
    if (camera.model == CameraModel::kUnknown) {
      if (options_.no_background) return;
      if (options_.background)
        Refuse(
            "expected a still background with texture at --background, found none; choose another place, or "
            "--background none for a camera that is known to stand still");
      result_.notices.push_back(seen_.background.empty()
                                    ? "no background with texture: the camera is taken to stand still"
                                    : "no background stands still: the camera is taken to stand still");
      if (!seen_.background.empty())
        result_.warnings.push_back("the background is unsteady: what the camera did is not known, and not taken off");
      return;
    }
    if (camera.disagreement > kUnsteady)
      result_.warnings.push_back(
          fmt::format("the background is unsteady: its patches move by {:.2g} pixels against "
                      "each other",
                      camera.disagreement));
    JudgeFollowing();
  }

  /// A background on the swinging mass, or on a beam that gives way, takes motion from the record.
  void JudgeFollowing() {
    const CameraMotion& camera = result_.camera;
    double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    for (const Steadied& s : places_) {
      if (!camera.poses[s.picture]) continue;
      const double target = Dot(s.place, result_.axis), still = Dot(camera.poses[s.picture]->shift, result_.axis);
      n += 1, a += target, b += still, aa += target * target, bb += still * still, ab += target * still;
    }
    const double var_a = aa / n - a * a / n / n, var_b = bb / n - b * b / n / n, cov = ab / n - a * b / n / n;
    if (!(var_a > 0 && var_b > 0) || std::sqrt(var_b / var_a) < kFollowsShare) return;
    const double correlation = cov / std::sqrt(var_a * var_b);
    if (std::abs(correlation) > kFollows) {
      result_.warnings.push_back(
          fmt::format("the background moves with the patch (correlation {:.2f}, {} of its motion): is it on the mass, "
                      "or on something that gives way?",
                      correlation, Percent(std::sqrt(var_b / var_a))));
    }
  }

  void SayLeftOut() {
    for (const LeftOut why : {LeftOut::kLost, LeftOut::kEdge, LeftOut::kAmbiguous, LeftOut::kNoStill,
                              LeftOut::kRepeated, LeftOut::kNoTimeStamp}) {
      const auto is_why = [why](const LeftOutPicture& left) { return left.why == why; };
      const auto count = std::count_if(result_.left_out.begin(), result_.left_out.end(), is_why);
      if (count == 0) continue;
      const auto first = std::find_if(result_.left_out.begin(), result_.left_out.end(), is_why);
      const std::string at =
          result_.times.t[first->picture] ? fmt::format(", first at {:.4g} s", *result_.times.t[first->picture]) : "";
      result_.warnings.push_back(fmt::format("{} picture{} left out (from picture {}{}): {}", count,
                                             count == 1 ? "" : "s", first->picture + 1, at, Reason(why)));
    }
    if (result_.missing > 0)
      result_.warnings.push_back(fmt::format("{} picture{} missing in {} gap{}: nothing is put in their place",
                                             result_.missing, result_.missing == 1 ? "" : "s",
                                             result_.times.gaps.size(), result_.times.gaps.size() == 1 ? "" : "s"));
  }

  const FilmObservations& seen_;
  const TrackOptions& options_;
  TrackResult result_;
  std::vector<Steadied> places_;
};

}  // namespace

double CalcMotionRms(const std::vector<Sighting>& sightings) {
  double n = 0;
  Point sum;
  double squares = 0;
  for (const Sighting& s : sightings) {
    if (!s.fit) continue;
    n += 1, sum = sum + s.fit->place, squares += Dot(s.fit->place, s.fit->place);
  }
  return n > 1 ? std::sqrt(std::max(0.0, squares / n - Dot(sum, sum) / n / n)) : 0;
}

TrackResult FinishTrack(const FilmObservations& seen, const TrackOptions& options) {
  return Finisher(seen, options).Finish();
}

}  // namespace uiclink::track
