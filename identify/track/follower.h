#pragma once

#include <optional>
#include <vector>

#include "identify/track/coarse_search.h"
#include "identify/track/image.h"
#include "identify/track/motion_blur.h"
#include "identify/track/patch_tracker.h"

namespace uiclink::track {

/// Why a picture gives no sample.
enum class LeftOut {
  kNot,          ///< it gives one
  kLost,         ///< nothing there looks like the patch
  kEdge,         ///< the patch leaves the picture
  kAmbiguous,    ///< two places look like it, and the motion so far does not say which
  kNoStill,      ///< no still background to tell the camera's motion by
  kRepeated,     ///< the picture repeats the one before while the patch should have moved on
  kNoTimeStamp,  ///< the container has no time stamp for it, or one that runs backwards
};

/// "lost", "left the picture", ...: for messages.
const char* Reason(LeftOut why);

/// The patch in one picture.
struct Sighting {
  std::optional<PatchFit> fit;
  LeftOut why = LeftOut::kNot;
};

/// Follows a patch from picture to picture: predicts it from its motion so far, looks around the prediction for
/// everything alike, and fits the reference there. Where the patch moves fast the reference is blurred as the shutter
/// blurs the picture: along the predicted step, by the share of it that the shutter is open. That share is found from
/// the first fast pictures (the one that the film looks like most) and kept.
class Follower {
 public:
  struct Options {
    PatchTracker::Options patch;
    bool swings = true;  ///< predicted from its motion and looked for in every picture; else expected where it was
  };

  Follower(const GrayView& reference, const Box& box, const Options& options);

  Sighting Follow(const GrayView& picture);

  const PatchTracker& tracker() const { return tracker_; }
  /// Share of the time that the shutter is open; empty where nothing moved fast enough to tell.
  std::optional<double> shutter() const;

  /// Least correlation with the reference of a patch that counts as seen. A patch of another place of a random texture
  /// reaches about 0.5, blur over a third of the patch leaves about 0.7.
  static constexpr double kLeastScore = 0.6;

 private:
  Point Predict() const;
  std::optional<Point> Choose(const CoarseSearch& search, const GrayView& picture, Point predicted,
                              bool* ambiguous) const;
  Sighting LookFor(const PatchTracker& tracker, const CoarseSearch& search, const GrayView& picture,
                   Point predicted) const;
  Sighting LookForBlurred(const GrayView& picture, Point predicted, Point step);
  Sighting Miss(const GrayView& picture, LeftOut why);

  PatchTracker tracker_;
  CoarseSearch search_;
  ReferencePicture reference_;
  Options options_;
  std::vector<Point> recent_;  // places of the last pictures without a gap, newest last, at most three
  double angle_ = 0;
  int misses_ = 0;                // pictures since it was last seen
  std::vector<double> shutters_;  // best share of each fast picture so far
};

}  // namespace uiclink::track
