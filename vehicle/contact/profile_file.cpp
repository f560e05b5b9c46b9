#include "vehicle/contact/profile_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "data/file.h"
#include "data/input_error.h"

namespace uiclink {
namespace {

constexpr std::size_t kFewestPoints = 10;
constexpr double kSamePoint = 1e-6;        // [m] closer points are one: the rounding of a file would be a slope there
constexpr double kSteepOverhang = 3;       // |dz/dy| from which on a step back in y is an overhang, not a bad point
constexpr double kSmallestMeasure = 0.02;  // [m] no tread is narrower
constexpr double kLargestMeasure = 0.5;    // [m] no wheel or rail head is wider

struct FilePoint {
  double y, z;
  int line;
};

std::string_view Trim(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\f\v";
  const std::size_t begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

std::vector<std::string_view> SplitWords(std::string_view line) {
  constexpr std::string_view kSeparators = " \t\r\f\v,;";
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(kSeparators); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kSeparators, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kSeparators, end);
  }
  return words;
}

std::optional<double> ParseNumber(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Reads the lines of either format.
class PointReader {
 public:
  PointReader(const std::string& file, ProfileKind kind, bool simpack) : file_(file), kind_(kind), simpack_(simpack) {}

  void Read(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    for (int line = 1; !text.empty(); ++line) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      const std::string_view whole = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      const std::string_view content = Trim(whole.substr(0, std::min(whole.find_first_of("#!%"), whole.size())));
      if (content.empty()) continue;
      if (simpack_ && !in_points_) {
        ReadKey(content, line);
      } else if (simpack_ && content.starts_with("point.end")) {
        in_points_ = false;
      } else {
        ReadPoint(content, line);
      }
    }
    if (points_.size() < kFewestPoints) {
      throw InputError(file_, 0, fmt::format("expected at least {} points, found {}", kFewestPoints, points_.size()));
    }
    const auto [first, last] = std::ranges::minmax_element(points_, {}, &FilePoint::y);
    if (const double width = last->y - first->y; width < kSmallestMeasure) {
      throw InputError(file_, 0,
                       fmt::format("expected a profile at least {:g} mm wide, found {:.3g} mm (lengths are in mm)",
                                   1e3 * kSmallestMeasure, 1e3 * width));
    }
  }

  std::vector<FilePoint>& points() { return points_; }

 private:
  void ReadPoint(std::string_view content, int line) {
    const std::vector<std::string_view> words = SplitWords(content);
    if (words.size() < 2 || words.size() > 3) {
      throw InputError(file_, line, fmt::format("expected two numbers, y and z, found \"{}\"", content));
    }
    std::array<double, 2> value{};
    for (std::size_t i = 0; i < 2; ++i) {
      const std::optional<double> number = ParseNumber(words[i]);
      if (!number) throw InputError(file_, line, fmt::format("expected a finite number, found \"{}\"", words[i]));
      value[i] = *number / units_per_metre_;
      if (std::abs(value[i]) > kLargestMeasure) {
        throw InputError(file_, line, fmt::format("expected a length below 500 mm, found {} mm", 1e3 * value[i]));
      }
    }
    points_.push_back({value[0], value[1], line});
  }

  /// A line of a SIMPACK file before its points: "key = value", or "point.begin".
  void ReadKey(std::string_view content, int line) {
    if (content.starts_with("point.begin")) {
      in_points_ = true;
      return;
    }
    const std::size_t equal = content.find('=');
    if (equal == std::string_view::npos) {
      section_ = content;
      return;
    }
    const std::string_view key = Trim(content.substr(0, equal));
    const std::string_view value = Trim(content.substr(equal + 1));
    if (key == "units.len.f") {
      units_per_metre_ = ParseNumber(value).value_or(0);
      if (!(units_per_metre_ > 0)) {
        throw InputError(file_, line, fmt::format("expected units.len.f > 0, found \"{}\"", value));
      }
    } else if (key == "shift.y" || key == "shift.z" || key == "rotate") {
      if (ParseNumber(value) != 0.0) {
        throw InputError(file_, line,
                         fmt::format("expected {} = 0 (points as they shall be used), found \"{}\"", key, value));
      }
    } else if (key == "type" && section_ == "header.begin") {
      const std::string_view wanted = kind_ == ProfileKind::kWheel ? "1" : "0";
      if (value != wanted) {
        throw InputError(file_, line,
                         fmt::format("expected the profile of a {}, type = {}, found type = {}",
                                     kind_ == ProfileKind::kWheel ? "wheel" : "rail", wanted, value));
      }
    }
  }

  std::string file_;
  ProfileKind kind_;
  bool simpack_;
  bool in_points_ = false;
  std::string_view section_;
  double units_per_metre_ = 1000;
  std::vector<FilePoint> points_;
};

/// Turns the axes of the file into those of Profile.
void OrientAxes(std::vector<FilePoint>& points, ProfileKind kind, const ProfileAxes& axes) {
  const auto by_y = [](const FilePoint& a, const FilePoint& b) { return a.y < b.y; };
  const auto [first, last] = std::minmax_element(points.begin(), points.end(), by_y);
  // Reference height: of the wheel at the tape circle, of the rail in its middle.
  const double y_reference = kind == ProfileKind::kWheel ? 0 : 0.5 * (first->y + last->y);
  const auto distance = [&](const FilePoint& p) { return std::abs(p.y - y_reference); };
  const double z_reference =
      std::min_element(points.begin(), points.end(), [&](const FilePoint& a, const FilePoint& b) {
        return distance(a) < distance(b);
      })->z;
  // The tip of a flange or the side of a head is farthest from it, and hangs down.
  const FilePoint extreme =
      *std::max_element(points.begin(), points.end(), [&](const FilePoint& a, const FilePoint& b) {
        return std::abs(a.z - z_reference) < std::abs(b.z - z_reference);
      });
  const bool up = axes.vertical == ProfileAxes::Vertical::kDetect ? extreme.z < z_reference
                                                                  : axes.vertical == ProfileAxes::Vertical::kUp;
  const bool to_field = axes.lateral == ProfileAxes::Lateral::kDetect
                            ? kind == ProfileKind::kRail || extreme.y < y_reference
                            : axes.lateral == ProfileAxes::Lateral::kField;
  for (FilePoint& p : points) {
    if (!up) p.z = -p.z;
    if (!to_field) p.y = -p.y;
  }
}

/// Points by strictly increasing y from the middle of the curve to both ends, up to where it overhangs.
ProfilePoints FollowCurve(const std::vector<FilePoint>& points, const std::string& file) {
  std::size_t steps_ahead = 0, steps_back = 0;  // points may stand twice
  for (std::size_t i = 1; i < points.size(); ++i) {
    steps_ahead += points[i].y > points[i - 1].y ? 1 : 0;
    steps_back += points[i].y < points[i - 1].y ? 1 : 0;
  }
  std::vector<FilePoint> ordered = points;
  if (steps_ahead < steps_back) std::reverse(ordered.begin(), ordered.end());

  const auto overhangs = [&](const FilePoint& from, const FilePoint& to) {
    const double dy = std::abs(to.y - from.y);
    if (std::abs(to.z - from.z) < kSteepOverhang * dy) {
      throw InputError(
          file, to.line,
          fmt::format("expected points along the curve in one direction, found y = {:.5g} mm after {:.5g} mm",
                      1e3 * to.y, 1e3 * from.y));
    }
    return true;
  };
  const auto same = [](const FilePoint& a, const FilePoint& b) {
    return std::hypot(a.y - b.y, a.z - b.z) < kSamePoint;
  };
  const std::size_t middle = ordered.size() / 2;
  std::vector<FilePoint> kept{ordered[middle]};
  for (std::size_t i = middle; i-- > 0;) {
    if (same(ordered[i], kept.back())) continue;
    if (ordered[i].y >= kept.back().y && overhangs(kept.back(), ordered[i])) break;
    kept.push_back(ordered[i]);
  }
  std::reverse(kept.begin(), kept.end());
  for (std::size_t i = middle + 1; i < ordered.size(); ++i) {
    if (same(ordered[i], kept.back())) continue;
    if (ordered[i].y <= kept.back().y && overhangs(kept.back(), ordered[i])) break;
    kept.push_back(ordered[i]);
  }
  if (kept.size() < kFewestPoints) {
    throw InputError(file, 0,
                     fmt::format("expected at least {} points along one curve, found {}", kFewestPoints, kept.size()));
  }
  ProfilePoints result;
  for (const FilePoint& p : kept) result.emplace_back(p.y, p.z);
  return result;
}

}  // namespace

ProfilePoints ParseProfilePoints(std::string_view text, const std::string& file, ProfileKind kind,
                                 const ProfileAxes& axes) {
  PointReader reader(file, kind, text.find("spline.begin") != std::string_view::npos);
  reader.Read(text);
  OrientAxes(reader.points(), kind, axes);
  return FollowCurve(reader.points(), file);
}

ProfilePoints ReadProfilePoints(const std::filesystem::path& path, ProfileKind kind, const ProfileAxes& axes) {
  return ParseProfilePoints(ReadFileWhole(path), path.string(), kind, axes);
}

Profile ReadProfile(const std::filesystem::path& path, ProfileKind kind, double sigma, const ProfileAxes& axes) {
  const ProfilePoints points = ReadProfilePoints(path, kind, axes);
  std::optional<Profile> fitted;
  try {
    fitted = FitProfile(path.filename().string(), points, sigma);
  } catch (const std::invalid_argument& fault) {
    throw InputError(path.string(), 0, fmt::format("expected points of a smooth curve, found: {}", fault.what()));
  }
  if (kind == ProfileKind::kRail) return *fitted;
  if (!fitted->Contains(0)) {
    throw InputError(path.string(), 0, "expected a wheel that reaches over y = 0, the tape circle");
  }
  return fitted->Shifted(0, -fitted->Eval(0).z);
}

}  // namespace uiclink
