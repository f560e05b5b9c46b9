#include "identify/track/target.h"

#include <fmt/format.h>

#include <algorithm>

#include "data/input_error.h"
#include "identify/track/moving_region.h"
#include "identify/track/patch_tracker.h"

namespace uiclink::track {
namespace {

void RequireInside(const std::string& file, const char* option, const Box& box, const GrayView& picture) {
  const Box inner = Grown(picture.Bounds(), -PatchTracker::kBorder);
  if (inner.Contains(box) && box.width >= PatchTracker::kSmallest && box.height >= PatchTracker::kSmallest) return;
  throw InputError(file, 0,
                   fmt::format("expected {} at least {} pixels wide and high and {} within the picture of {} x {}, "
                               "found {},{},{},{}",
                               option, PatchTracker::kSmallest, PatchTracker::kBorder, picture.width, picture.height,
                               box.x, box.y, box.width, box.height));
}

std::string ListIds(const std::vector<Tag>& tags) {
  std::string ids;
  for (const Tag& tag : tags) ids += fmt::format("{}{}", ids.empty() ? "" : ", ", tag.id);
  return ids;
}

std::vector<Target> TakeTags(const std::string& file, const GrayView& first, const TrackOptions& options) {
  std::vector<Tag> tags = FindTags(first);
  if (tags.empty()) {
    throw InputError(file, 0,
                     "expected an ArUco or AprilTag marker in the first picture, found none; it needs a white rim and "
                     "about 20 pixels or more, or say where the patch is with --roi X,Y,W,H");
  }
  if (options.tag_id) {
    const std::string ids = ListIds(tags);
    std::erase_if(tags, [&](const Tag& tag) { return tag.id != *options.tag_id; });
    if (tags.empty())
      throw InputError(file, 0,
                       fmt::format("expected the tag {} in the first picture, found {}", *options.tag_id, ids));
  }
  std::vector<Target> targets;
  for (const Tag& tag : tags) {
    const Box box = TagBox(tag, Grown(first.Bounds(), -PatchTracker::kBorder));
    if (box.width >= PatchTracker::kSmallest && box.height >= PatchTracker::kSmallest) targets.push_back({box, tag});
  }
  if (targets.empty()) throw InputError(file, 0, "expected a tag within the first picture, found one at its edge");
  return targets;
}

}  // namespace

std::vector<Target> FindTargets(const std::filesystem::path& film, const GrayView& first, const TrackOptions& options) {
  if (options.background) RequireInside(film.string(), "--background", *options.background, first);
  if (options.tag) return TakeTags(film.string(), first, options);
  if (options.roi) {
    RequireInside(film.string(), "--roi", *options.roi, first);
    return {{*options.roi, std::nullopt}};
  }
  const auto progress = [&](int pictures) {
    if (options.progress) options.progress("looking for what swings", pictures, kLongest);
  };
  const MovingRegion region = FindMovingRegion(film, progress);
  RequireInside(film.string(), "what swings most", region.box, first);
  return {{region.box, std::nullopt}};
}

}  // namespace uiclink::track
