// `identify track`: a filmed ring-down -> a record.

#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "data/file.h"
#include "data/input_error.h"
#include "identify/commands.h"
#include "identify/track/overlay.h"
#include "identify/track/track.h"
#include "identify/track/track_report.h"
#include "identify/write_record.h"

namespace uiclink {
namespace {

struct TrackArguments {
  std::string film, record, overlay, json;
  std::string roi, background, axis = "principal", direction;
  std::optional<double> mass_kg;
  bool quiet = false;
  track::TrackOptions options;
};

/// "X,Y,W,H" in whole pixels; empty where it is none.
std::optional<track::Box> ParseBox(const std::string& text) {
  std::array<int, 4> numbers{};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto [stop, error] = std::from_chars(at, end, numbers[i]);
    const bool last = i + 1 == numbers.size();
    if (error != std::errc() || (last ? stop != end : stop == end || *stop != ',')) return std::nullopt;
    at = last ? stop : stop + 1;
  }
  const track::Box box{numbers[0], numbers[1], numbers[2], numbers[3]};
  if (box.x < 0 || box.y < 0 || box.width < 1 || box.height < 1) return std::nullopt;
  return box;
}

std::string CheckBox(const std::string& text) {
  return ParseBox(text) ? "" : "expected X,Y,W,H in pixels of the first picture, found \"" + text + '"';
}

std::string CheckBackground(const std::string& text) { return text == "none" ? "" : CheckBox(text); }

/// CLI::PositiveNumber lets "nan" and "inf" pass.
std::string CheckPositive(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool good = error == std::errc() && end == text.data() + text.size() && value > 0 && value < 1e9;
  return good ? "" : "expected a number above 0, found \"" + text + '"';
}

void AddOptions(CLI::App* command, TrackArguments* a) {
  command->add_option("film", a->film, "film, as FFmpeg reads it: MP4, MOV, MKV, AVI, ...")->required();
  command->add_option("--record", a->record, "the record to write")->type_name("FILE")->required();
  CLI::Option* const scale = command->add_option("--mm-per-pixel", a->options.mm_per_pixel, "scale, at the patch")
                                 ->type_name("MM")
                                 ->check(CheckPositive, "");
  CLI::Option* const tag_mm =
      command->add_option("--tag-mm", a->options.tag_mm, "scale from a tag: side of its black square [mm]")
          ->type_name("MM")
          ->check(CheckPositive, "")
          ->excludes(scale);
  CLI::Option* const roi =
      command->add_option("--roi", a->roi, "patch to follow, in the first picture (default: what swings most)")
          ->type_name("X,Y,W,H")
          ->check(CheckBox, "");
  CLI::Option* const tag =
      command->add_flag("--tag", a->options.tag, "follow an ArUco or AprilTag marker")->excludes(roi);
  command->add_option("--tag-id", a->options.tag_id, "which tag (default: the one that swings most)")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber, "");
  command->add_option("--background", a->background, "something that stands still (default: found), or none")
      ->type_name("X,Y,W,H")
      ->check(CheckBackground, "");
  command->add_option("--axis", a->axis, "x (right), y (up), or principal: the direction of the motion")
      ->check(CLI::IsMember({"x", "y", "principal"}))
      ->capture_default_str();
  command->add_option("--rate", a->options.rate_hz, "pictures a second, where the film's time stamps are wrong")
      ->type_name("HZ")
      ->check(CheckPositive, "");
  command->add_option("--direction", a->direction, "direction of the link, for the record's header")
      ->check(CLI::IsMember({"lateral", "longitudinal"}));
  command->add_option("--mass", a->mass_kg, "mass on the link [kg], for the record's header")->check(CheckPositive, "");
  command->add_option("--overlay", a->overlay, "picture of what was read (default: the record's name with .png)")
      ->type_name("FILE");
  command->add_option("--json", a->json, "write what was found as JSON to FILE; - for standard output, alone there")
      ->type_name("FILE");
  command->add_flag("--quiet,-q", a->quiet, "nothing on standard output");
  command->final_callback([a, scale, tag_mm, roi, tag] {
    if (scale->count() + tag_mm->count() == 0) throw CLI::RequiredError("--mm-per-pixel or --tag-mm");
    if (tag_mm->count() > 0 && roi->count() == 0 && tag->count() == 0) a->options.tag = true;
  });
  command->footer(
      "Examples:\n"
      "  identify track swing.mp4 --mm-per-pixel 0.2 --record lateral_01.txt\n"
      "  identify track swing.mp4 --tag-mm 40 --axis x --record lateral_01.txt --direction lateral\n"
      "  identify track swing.mov --roi 610,320,80,60 --background 40,40,200,120 --mm-per-pixel 0.2 --record r.txt\n\n"
      "Tips: a short exposure and a marker with much texture; the camera square to the motion; a still, textured\n"
      "background in the picture tells the camera's own shake. A rolling shutter shears motion along y in time.");
}

std::string FormatTrackRecord(const TrackArguments& a, const track::TrackResult& result) {
  WrittenRecord record{
      .source = fmt::format("film {}, patch {},{},{},{}, {:.6g} mm/pixel (identify track)", result.file, result.roi.x,
                            result.roi.y, result.roi.width, result.roi.height, result.mm_per_pixel),
      .direction = {},
      .mass_kg = a.mass_kg,
      .g = {},
      .t = result.t,
      .y = result.y,
      .uncertainty = result.uncertainty};
  if (!a.direction.empty())
    record.direction = a.direction == "lateral" ? Direction::kLateral : Direction::kLongitudinal;
  for (double& y : record.y) y *= 1e3;
  for (double& u : record.uncertainty) u *= 1e3;
  return track::FormatTrackComments(result) + FormatRecord(record);
}

void Emit(const TrackArguments& a, const track::TrackResult& result, const std::string& overlay) {
  const std::string json = track::FormatTrackJson(result);
  if (!a.json.empty() && a.json != "-") WriteFileWhole(a.json, json);
  if (a.json == "-") {
    std::cout << json;
  } else if (!a.quiet) {
    std::cout << track::FormatTrack(result) << fmt::format("Written: {} {}\n", a.record, overlay);
  }
  if (!std::cout.flush()) throw InputError("standard output", 0, "expected room for the result, found none");
}

/// Progress for a person at a terminal; silent otherwise.
std::function<void(const std::string&, int, int)> MakeProgress(const TrackArguments& a) {
  if (a.quiet || a.json == "-" || isatty(STDERR_FILENO) == 0) return {};
  return [](const std::string& what, int done, int of) {
    fmt::print(stderr, "\r\033[K{} {}/{} ", what, done, of);
    std::fflush(stderr);
  };
}

}  // namespace

Command AddTrackCommand(CLI::App* program) {
  CLI::App* const command = program->add_subcommand("track", "a filmed ring-down -> a record");
  const auto a = std::make_shared<TrackArguments>();
  AddOptions(command, a.get());
  const auto run = [a] {
    track::TrackOptions& options = a->options;
    if (!a->roi.empty()) options.roi = ParseBox(a->roi);
    options.no_background = a->background == "none";
    if (!a->background.empty() && !options.no_background) options.background = ParseBox(a->background);
    options.axis = a->axis == "x" ? track::Axis::kX : a->axis == "y" ? track::Axis::kY : track::Axis::kPrincipal;
    options.progress = MakeProgress(*a);
    const track::TrackResult result = track::TrackFilm(a->film, options);
    if (options.progress) fmt::print(stderr, "\r\033[K");
    for (const std::string& notice : result.notices) fmt::print(stderr, "{}: note: {}\n", a->film, notice);
    for (const std::string& warning : result.warnings) fmt::print(stderr, "{}: {}\n", a->film, warning);
    const std::string overlay =
        a->overlay.empty() ? std::filesystem::path(a->record).replace_extension(".png").string() : a->overlay;
    WriteFileWhole(a->record, FormatTrackRecord(*a, result));
    track::WriteOverlay(result, overlay);
    Emit(*a, result, overlay);
    return result.warnings.empty() ? 0 : 1;
  };
  return {.app = command, .run = run};
}

}  // namespace uiclink
