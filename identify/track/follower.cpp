#include "identify/track/follower.h"

#include <algorithm>
#include <cmath>

namespace uiclink::track {
namespace {

constexpr double kNear = 12;           // of the prediction, beside a whole step more [pixel]
constexpr double kRivalBehind = 0.05;  // in score: what half a reduced pixel may cost the better one
constexpr double kRivalScore = 0.8;
constexpr double kLeastInliers = 0.3;
constexpr double kFast = 6;                   // a step from where blur may matter [pixel]
constexpr std::size_t kShutterPictures = 12;  // by which the shutter is told

double Distance(Point a, Point b) { return std::hypot(a.x - b.x, a.y - b.y); }

bool LooksRight(const std::optional<PatchFit>& fit) {
  return fit && fit->score >= Follower::kLeastScore && fit->inliers >= kLeastInliers;
}

}  // namespace

const char* Reason(LeftOut why) {
  switch (why) {
    case LeftOut::kLost:
      return "the patch was not found";
    case LeftOut::kEdge:
      return "the patch left the picture";
    case LeftOut::kAmbiguous:
      return "two places look like the patch";
    case LeftOut::kNoStill:
      return "no still background was found";
    case LeftOut::kRepeated:
      return "the picture repeats the one before";
    case LeftOut::kNoTimeStamp:
      return "the picture has no time stamp, or one that runs backwards";
    case LeftOut::kNot:
      break;
  }
  return "";
}

Follower::Follower(const GrayView& reference, const Box& box, const Options& options)
    : tracker_(reference, box, options.patch),
      search_(reference, box),
      reference_(reference, box),
      options_(options),
      recent_{box.Centre()} {}

std::optional<double> Follower::shutter() const {
  if (shutters_.empty()) return std::nullopt;
  std::vector<double> sorted = shutters_;
  std::sort(sorted.begin(), sorted.end());
  return sorted[sorted.size() / 2];
}

Point Follower::Predict() const {
  const Point last = recent_.back();
  if (!options_.swings || recent_.size() == 1 || misses_ > 0) return last;
  const Point before = recent_[recent_.size() - 2];
  if (recent_.size() == 2) return 2 * last - before;
  return 3 * last - 3 * before + recent_.front();  // constant acceleration
}

std::optional<Point> Follower::Choose(const CoarseSearch& search, const GrayView& picture, Point predicted,
                                      bool* ambiguous) const {
  const double step = recent_.size() > 1 ? Distance(recent_.back(), recent_[recent_.size() - 2]) : 0;
  // After a miss the patch may be anywhere that it can have gone: ever wider, at last everywhere.
  const double radius = (kNear + step) * std::exp2(std::min(misses_, 10));
  const std::optional<Lookalikes> found = search.Find(picture, predicted, radius);
  if (!found) return std::nullopt;
  const Lookalike& best = found->best;
  if (!found->rival || found->rival->score < std::max(kRivalScore, best.score - kRivalBehind)) return best.place;
  const Point rival = found->rival->place;
  const Point nearer = Distance(best.place, predicted) <= Distance(rival, predicted) ? best.place : rival;
  *ambiguous = misses_ > 0 || Distance(nearer, predicted) > 0.25 * Distance(best.place, rival);
  return nearer;
}

Sighting Follower::Miss(const GrayView& picture, LeftOut why) {
  const Point predicted = Predict();
  const Box& box = tracker_.box();
  const double margin = PatchTracker::kBorder;
  const bool near_edge = predicted.x - 0.5 * box.width < margin || predicted.y - 0.5 * box.height < margin ||
                         predicted.x + 0.5 * box.width > picture.width - margin ||
                         predicted.y + 0.5 * box.height > picture.height - margin;
  ++misses_;
  recent_ = {recent_.back()};
  return {.fit = std::nullopt, .why = why == LeftOut::kLost && near_edge ? LeftOut::kEdge : why};
}

Sighting Follower::LookFor(const PatchTracker& tracker, const CoarseSearch& search, const GrayView& picture,
                           Point predicted) const {
  std::optional<PatchFit> fit;
  if (!options_.swings && misses_ == 0) fit = tracker.Find(picture, predicted, angle_);
  if (!LooksRight(fit)) {
    bool ambiguous = false;
    const std::optional<Point> start = Choose(search, picture, predicted, &ambiguous);
    if (ambiguous) return {.fit = std::nullopt, .why = LeftOut::kAmbiguous};
    if (start) fit = tracker.Find(picture, *start, angle_);
  }
  if (!LooksRight(fit)) return {.fit = std::nullopt, .why = LeftOut::kLost};
  return {.fit = fit, .why = LeftOut::kNot};
}

Sighting Follower::LookForBlurred(const GrayView& picture, Point predicted, Point step) {
  const bool decided = shutters_.size() >= kShutterPictures;
  const std::vector<double> shares = decided ? std::vector{*shutter()} : std::vector{0.0, 0.25, 0.5, 0.75, 1.0};
  Sighting best{.fit = std::nullopt, .why = LeftOut::kLost};
  double best_share = 0;
  for (const double share : shares) {
    Sighting sighting;
    if (share * Distance(step, {}) < 1) {
      sighting = LookFor(tracker_, search_, picture, predicted);
    } else {
      const ReferencePicture blurred = reference_.Blurred(share * step);
      sighting = LookFor(PatchTracker(blurred.view(), blurred.box(), options_.patch),
                         CoarseSearch(blurred.view(), blurred.box()), picture, predicted);
    }
    if (!sighting.fit && !best.fit && sighting.why == LeftOut::kAmbiguous) best.why = LeftOut::kAmbiguous;
    if (!sighting.fit || (best.fit && sighting.fit->score <= best.fit->score)) continue;
    best = sighting, best_share = share;
  }
  if (best.fit && !decided) shutters_.push_back(best_share);
  return best;
}

Sighting Follower::Follow(const GrayView& picture) {
  const Point predicted = Predict(), step = predicted - recent_.back();
  const bool fast = options_.swings && misses_ == 0 && Distance(step, {}) > kFast;
  const Sighting sighting =
      fast ? LookForBlurred(picture, predicted, step) : LookFor(tracker_, search_, picture, predicted);
  if (!sighting.fit) return Miss(picture, sighting.why);
  if (misses_ > 0) recent_.clear();
  misses_ = 0;
  angle_ = sighting.fit->angle;
  recent_.push_back(sighting.fit->place);
  if (recent_.size() > 3) recent_.erase(recent_.begin());
  return sighting;
}

}  // namespace uiclink::track
