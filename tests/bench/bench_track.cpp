// Following a patch through films of 1280 x 720 pixels at 50 pictures a second, decoding included: processor time
// against the film's own length.

#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "identify/track/track.h"
#include "tests/bench/ratio.h"
#include "tests/cli/temporary_folder.h"
#include "tests/support/film_maker.h"

namespace uiclink {
namespace {

constexpr double kSeconds = 12;

/// A swing of 30 mm at 0.2 mm a pixel and 1 Hz.
FilmSettings Film(const std::string& codec, double seconds) {
  FilmSettings s{.width = 1280, .height = 720, .rate_hz = 50, .object_at = {640.3, 360.2}};
  s.pictures = static_cast<int>(seconds * s.rate_hz);
  s.codec = codec, s.noise = 2;
  s.motion = [](double t) { return track::Point{150 * std::exp(-0.1 * t) * std::cos(2 * std::numbers::pi * t), 0}; };
  return s;
}

Comparison Case(const std::string& name, const std::filesystem::path& film, bool chosen) {
  track::TrackOptions options{.mm_per_pixel = 0.2};
  if (chosen) options.roi = track::Box{749, 334, 82, 52};
  const auto run = [=] { return track::TrackFilm(film, options); };
  return {.name = name,
          .ours = Timed("processor time", 1, run),
          .theirs = {"the film's length", [] { return kSeconds; }},
          .least_ratio = 5,
          .difference =
              [=] {
                const track::TrackResult result = run();
                double largest = 0;
                const FilmSettings s = Film("", kSeconds);
                for (std::size_t i = 0; i < result.t.size(); ++i) {
                  const double truth = Dot(s.motion(result.t[i]) - s.motion(result.t[0]), result.axis);
                  largest = std::max(largest, std::abs(result.FramePixels(result.y[i]) - truth));
                }
                return largest;
              },
          .largest_difference = 0.5,
          .unit = "pixel",
          .iterations = 3};
}

}  // namespace
}  // namespace uiclink

int main(int argc, char** argv) {
  using namespace uiclink;
  const TemporaryFolder folder;
  std::vector<Comparison> comparisons;
  for (const char* codec : {"mp4v", "avc1"}) {
    const std::filesystem::path film = folder.path() / (std::string(codec) + ".mp4");
    MakeFilm(Film(codec, kSeconds), film);
    const std::string kind = codec == std::string("mp4v") ? "MPEG-4" : "H.264";
    comparisons.push_back(Case("track/720p50 " + kind + ", --roi", film, true));
    comparisons.push_back(Case("track/720p50 " + kind + ", what swings", film, false));
  }
  return RunComparisons(argc, argv, comparisons);
}
