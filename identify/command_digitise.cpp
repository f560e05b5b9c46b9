// `identify digitise`: a scanned, photographed or exported plot -> a record.

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "data/file.h"
#include "data/input_error.h"
#include "identify/commands.h"
#include "identify/digitise/digitise.h"
#include "identify/record.h"
#include "identify/upper_median.h"
#include "identify/write_record.h"

namespace uiclink {
namespace {

struct DigitiseArguments {
  std::string image, record, overlay, json;
  std::string x_range, y_range, direction, unit = "mm";
  std::vector<std::string> points;
  std::optional<double> mass_kg;
  bool quiet = false;
  digitise::DigitiseOptions options;
};

std::optional<double> ParseValue(std::string_view text) {
  double value = 0;
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = !text.empty() && error == std::errc() && end == text.data() + text.size();
  return whole && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

/// "A,B" as two numbers; either may be missing where `may_lack` says so.
std::optional<std::array<std::optional<double>, 2>> ParsePair(std::string_view text, bool may_lack) {
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos) return std::nullopt;
  const std::array<std::string_view, 2> parts{text.substr(0, comma), text.substr(comma + 1)};
  std::array<std::optional<double>, 2> pair;
  for (std::size_t i = 0; i < 2; ++i) {
    pair[i] = ParseValue(parts[i]);
    if (!pair[i] && !(may_lack && parts[i].empty())) return std::nullopt;
  }
  if (!pair[0] && !pair[1]) return std::nullopt;
  return pair;
}

std::optional<digitise::AxisRange> ParseRange(const std::string& text) {
  const auto pair = ParsePair(text, false);
  if (!pair) return std::nullopt;
  return digitise::AxisRange{*(*pair)[0], *(*pair)[1]};
}

std::string CheckRange(const std::string& text) {
  const auto range = ParseRange(text);
  return range && range->low < range->high ? "" : "expected LOW,HIGH with LOW below HIGH, found \"" + text + '"';
}

/// "PX,PY=T,Y".
std::optional<digitise::CalibrationPoint> ParsePoint(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) return std::nullopt;
  const auto pixel = ParsePair(text.substr(0, equals), false), value = ParsePair(text.substr(equals + 1), true);
  if (!pixel || !value) return std::nullopt;
  return digitise::CalibrationPoint{{*(*pixel)[0], *(*pixel)[1]}, (*value)[0], (*value)[1]};
}

std::string CheckPoint(const std::string& text) {
  return ParsePoint(text) ? "" : "expected PX,PY=T,Y (T or Y may be left out), found \"" + text + '"';
}

/// CLI::PositiveNumber lets "nan" and "inf" pass.
std::string CheckPositive(const std::string& text) {
  const std::optional<double> value = ParseValue(text);
  return value && *value > 0 && *value < 1e9 ? "" : "expected a number above 0, found \"" + text + '"';
}

void AddOptions(CLI::App* command, DigitiseArguments* a) {
  command->add_option("image", a->image, "picture of a plot: PNG, JPEG, TIFF, BMP, WebP")->required();
  command->add_option("--record", a->record, "the record to write")->type_name("FILE")->required();
  command->add_option("--x-range", a->x_range, "times at the left and the right side of the frame [s]")
      ->type_name("T0,T1")
      ->check(CheckRange, "");
  command->add_option("--y-range", a->y_range, "displacements at the bottom and the top of the frame")
      ->type_name("Y0,Y1")
      ->check(CheckRange, "");
  command
      ->add_option("--point", a->points,
                   "instead of a frame, two or more: at the pixel PX,PY (from the left, from the top, first = 0) the "
                   "axes say T,Y; one of the two may be left out")
      ->type_name("PX,PY=T,Y")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->check(CheckPoint, "");
  command->add_option("--curve", a->options.curve, "which of several curves: its colour (name, #rrggbb) or number")
      ->type_name("COLOUR|N");
  command->add_option("--unit", a->unit, "unit of the displacement axis: " + DisplacementUnits())
      ->check(CLI::IsMember({"mm", "cm", "m", "um", "in", "mrad", "rad", "deg"}))
      ->capture_default_str();
  command->add_option("--rate", a->options.rate_hz, "samples a second (default: as many as the picture resolves)")
      ->type_name("HZ")
      ->check(CheckPositive, "");
  command->add_option("--direction", a->direction, "direction of the link, for the record's header")
      ->check(CLI::IsMember({"lateral", "longitudinal"}));
  command->add_option("--mass", a->mass_kg, "mass on the link [kg], for the record's header")->check(CheckPositive, "");
  command->add_option("--overlay", a->overlay, "picture of what was read (default: the record's name, .overlay.png)")
      ->type_name("FILE");
  command->add_option("--json", a->json, "write what was found as JSON to FILE; - for standard output, alone there")
      ->type_name("FILE");
  command->add_flag("--quiet,-q", a->quiet, "nothing on standard output");
  command->footer(
      "Examples:\n"
      "  identify digitise plot.png --x-range 0,15 --y-range -40,40 --record lateral_01.txt\n"
      "  identify digitise scan.jpg --x-range 0,15 --y-range -40,40 --curve blue --record r.txt --direction lateral\n"
      "  identify digitise plot.png --point 80,520=0,-40 --point 1180,40=15,40 --record r.txt\n\n"
      "Look at the overlay before you use the record. Exit codes: 0 read; 1 read, but look at the warnings;\n"
      "2 not read: frame or curve missing or ambiguous.");
}

std::string FormatDigitisedRecord(const DigitiseArguments& a, const digitise::Digitised& read) {
  WrittenRecord record{
      .source = fmt::format("digitised from {}, {} curve, {:.4g} {} and {:.4g} ms a pixel (identify digitise {})",
                            std::filesystem::path(a.image).filename().string(), read.colour, read.y_per_px, a.unit,
                            1e3 * read.s_per_px, UICLINK_VERSION),
      .direction = {},
      .mass_kg = a.mass_kg,
      .g = {},
      .unit = a.unit,
      .t = read.t,
      .y = read.y,
      .uncertainty = read.uncertainty};
  if (!a.direction.empty())
    record.direction = a.direction == "lateral" ? Direction::kLateral : Direction::kLongitudinal;
  return FormatRecord(record);
}

std::string FormatText(const DigitiseArguments& a, const digitise::Digitised& read, const std::string& overlay) {
  std::string text = fmt::format("{}: {} curve, {:.1f} px wide\n", a.image, read.colour, read.line_width_px);
  text += fmt::format("  scale        {:.4g} {} and {:.4g} ms a pixel; {} within {:.2f} px; tilt {:.2f} degrees\n",
                      read.y_per_px, a.unit, 1e3 * read.s_per_px, a.points.empty() ? "frame" : "points",
                      read.frame_closure_px, read.tilt_deg);
  for (const std::string& note : read.notes) text += "  axes         " + note + '\n';
  text +=
      fmt::format("  read         {} samples at {:g} Hz, {:.3f} to {:.3f} s; uncertainty {:.2g} {} (median)\n",
                  read.t.size(), read.rate_hz, read.t.front(), read.t.back(), UpperMedian(read.uncertainty), a.unit);
  text += fmt::format(
      "  checked      {:.1f} % of the columns, ink under {:.1f} % of the line, {:.1f} % of the ink on it; drawn again "
      "{:.3f} off (rms)\n",
      100 * read.columns_read, 100 * read.line_found, 100 * read.ink_explained, read.rms_share);
  return text + fmt::format("Written: {} {}\n", a.record, overlay);
}

std::string FormatJson(const DigitiseArguments& a, const digitise::Digitised& read, const std::string& overlay) {
  nlohmann::ordered_json frame = nlohmann::ordered_json::array();
  if (a.points.empty())
    for (const digitise::Pixel& corner : read.frame) frame.push_back({corner.x, corner.y});
  nlohmann::ordered_json gaps = nlohmann::ordered_json::array();
  for (const auto& [from, to] : read.gaps) gaps.push_back({{"from_s", from}, {"to_s", to}});
  const nlohmann::ordered_json json{
      {"schema", "digitise/1"},
      {"image", a.image},
      {"record", a.record},
      {"overlay", overlay},
      {"curve", {{"colour", read.colour}, {"width_px", read.line_width_px}, {"blur_px", read.blur_px}}},
      {"frame", frame},
      {"scale",
       {{"unit", a.unit},
        {"displacement_per_px", read.y_per_px},
        {"s_per_px", read.s_per_px},
        {"residual_px", read.frame_closure_px},
        {"tilt_deg", read.tilt_deg},
        {"bow_px", read.bow_px}}},
      {"samples", read.t.size()},
      {"rate_hz", read.rate_hz},
      {"from_s", read.t.front()},
      {"to_s", read.t.back()},
      {"median_uncertainty", UpperMedian(read.uncertainty)},
      {"checks",
       {{"columns_read", read.columns_read},
        {"line_found", read.line_found},
        {"ink_explained", read.ink_explained},
        {"rms_share", read.rms_share},
        {"outliers", read.outliers},
        {"bridged_px", read.bridged_px}}},
      {"gaps", gaps},
      {"notes", read.notes},
      {"warnings", read.warnings}};
  return json.dump(2) + '\n';
}

void FillOptions(DigitiseArguments* a) {
  if (!a->x_range.empty()) a->options.time = ParseRange(a->x_range);
  if (!a->y_range.empty()) a->options.displacement = ParseRange(a->y_range);
  for (const std::string& point : a->points) a->options.points.push_back(*ParsePoint(point));
}

int RunDigitise(DigitiseArguments a) {
  FillOptions(&a);
  const digitise::Picture picture = digitise::ReadPicture(a.image);
  const digitise::Digitised read = digitise::Digitise(picture, a.image, a.options);
  const std::string overlay =
      a.overlay.empty() ? std::filesystem::path(a.record).replace_extension(".overlay.png").string() : a.overlay;
  WriteFileWhole(a.record, FormatDigitisedRecord(a, read));
  digitise::WritePicture(overlay, digitise::DrawOverlay(picture, read));
  for (const std::string& warning : read.warnings) fmt::print(stderr, "{}: {}\n", a.image, warning);
  const std::string json = FormatJson(a, read, overlay);
  if (!a.json.empty() && a.json != "-") WriteFileWhole(a.json, json);
  if (a.json == "-") {
    std::cout << json;
  } else if (!a.quiet) {
    std::cout << FormatText(a, read, overlay);
  }
  if (!std::cout.flush()) throw InputError("standard output", 0, "expected room for the result, found none");
  return read.warnings.empty() ? 0 : 1;
}

}  // namespace

Command AddDigitiseCommand(CLI::App* program) {
  CLI::App* const command = program->add_subcommand("digitise", "a plot in a picture -> a record");
  const auto a = std::make_shared<DigitiseArguments>();
  AddOptions(command, a.get());
  return {.app = command, .run = [a] { return RunDigitise(*a); }};
}

}  // namespace uiclink
