// From columns of numbers to a record: time axis, units, plausibility, and what is known about the measurement.

#include "identify/record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "data/file.h"
#include "data/input_error.h"
#include "identify/record_parts.h"
#include "identify/upper_median.h"

namespace uiclink {
namespace {

using record_parts::Header;
using record_parts::RawRecord;
using record_parts::Unit;

// --- time axis ---------------------------------------------------------------------------------------------------

/// The coarsest decimal step 10^-d [s] (d = 0..9) that all time stamps are multiples of: their printed resolution. 0 if
/// none is.
double PrintedResolution(const std::vector<double>& t) {
  int decimals = 0;
  double scale = 1;
  for (const double time : t) {
    // 1e-6 of a unit in the last place: far above the rounding of a double (1e-16 of 15 s = 1e-6 of 1e-9 s).
    while (std::abs(time * scale - std::round(time * scale)) > 1e-6 + 4e-16 * std::abs(time) * scale) {
      if (++decimals > 9) return 0;
      scale *= 10;
    }
  }
  return 1 / scale;
}

struct Grid {
  double start;
  double step;
};

/// Least-squares line through the time stamps. Written about the middle, where start and step are independent.
Grid FitGrid(const std::vector<double>& t) {
  const double middle = 0.5 * static_cast<double>(t.size() - 1);
  double sum = 0;
  double moment = 0;
  double inertia = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    const double x = static_cast<double>(i) - middle;
    sum += t[i] - t[0];
    moment += x * (t[i] - t[0]);
    inertia += x * x;
  }
  const double step = moment / inertia;
  return {t[0] + sum / static_cast<double>(t.size()) - middle * step, step};
}

double LargestDeviation(const std::vector<double>& t, const Grid& grid) {
  double largest = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    largest = std::max(largest, std::abs(t[i] - grid.start - grid.step * static_cast<double>(i)));
  }
  return largest;
}

/// The nearest integer where the rate is one within rounding.
double SnapRate(double rate_hz) {
  const double whole = std::round(rate_hz);
  return whole > 0 && std::abs(rate_hz - whole) < 1e-9 * whole ? whole : rate_hz;
}

/// The grid with the rate that the header states, if no time stamp is further from it than `tolerance`; otherwise the
/// least-squares one, which rounding errors that follow each other can tilt.
Grid FitGrid(const std::vector<double>& t, const std::optional<double>& stated_hz, double tolerance) {
  const Grid fitted = FitGrid(t);
  if (!stated_hz) return fitted;
  const double middle = 0.5 * static_cast<double>(t.size() - 1);
  const Grid stated{fitted.start + middle * (fitted.step - 1 / *stated_hz), 1 / *stated_hz};
  return LargestDeviation(t, stated) <= tolerance ? stated : fitted;
}

void PutOnGrid(double start, double rate_hz, std::size_t samples, Record* record) {
  record->uniform = true;
  record->sampling_hz = rate_hz;
  record->t.resize(samples);
  for (std::size_t i = 0; i < samples; ++i) record->t[i] = start + static_cast<double>(i) / rate_hz;
}

/// Seconds since 1970 pass, milliseconds since then do not.
void RequireSeconds(const RawRecord& raw, const std::string& file) {
  constexpr double kMaxTime = 1e10;
  const auto first =
      std::find_if(raw.time.begin(), raw.time.end(), [=](double time) { return !(std::abs(time) <= kMaxTime); });
  if (first == raw.time.end()) return;
  throw InputError(file, raw.lines.LineOf(static_cast<std::size_t>(first - raw.time.begin())),
                   fmt::format("expected a time in seconds, found {:g}; name the column \"t [ms]\" if it is in "
                               "milliseconds, or give --rate HZ to ignore it",
                               *first));
}

void RequireIncreasing(const RawRecord& raw, const std::string& file) {
  const std::vector<double>& t = raw.time;
  std::size_t first = 0;
  std::size_t count = 0;
  for (std::size_t i = 1; i < t.size(); ++i) {
    if (t[i] > t[i - 1]) continue;
    if (count++ == 0) first = i;
  }
  if (count == 0) return;
  const int line = raw.lines.LineOf(first);
  // A column that falls or stands still in more than one step of ten is no clock.
  if (10 * count > t.size()) {
    throw InputError(
        file, line,
        fmt::format("expected increasing times in column 1, found {:g} after {:g} and {} steps more that do "
                    "not increase; if the file has no time column, give --rate HZ and --column N",
                    t[first], t[first - 1], count - 1));
  }
  const bool repeated = t[first] == t[first - 1];
  std::string message =
      fmt::format("expected a time after {:.9g} s, found {:.9g} s: time {}; {}", t[first - 1], t[first],
                  repeated ? "repeats" : "runs backwards",
                  repeated ? "write time with more decimals, or give --rate HZ to ignore the time column"
                           : "keep one run per file, in the order of time");
  if (count > 1) message += fmt::format("; and {} more line{} like it", count - 1, count == 2 ? "" : "s");
  throw InputError(file, line, message);
}

/// Gaps are faults where the steps are otherwise even (nine of ten within 10 % of the median) and the record does not
/// say itself that samples are missing; such a record, and an irregular one, is taken as it is, with a notice.
void JudgeIrregularSteps(const RawRecord& raw, const std::string& file, Record* record) {
  const std::vector<double>& t = raw.time;
  std::vector<double> steps(t.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = t[i + 1] - t[i];
  const double median = UpperMedian(steps);
  const auto even =
      std::count_if(steps.begin(), steps.end(), [=](double s) { return std::abs(s - median) <= 0.1 * median; });
  const auto is_gap = [=](double s) { return s > 1.5 * median; };
  const auto gap = std::find_if(steps.begin(), steps.end(), is_gap);
  if (gap == steps.end() || 10 * even < 9 * static_cast<std::ptrdiff_t>(steps.size())) {
    const auto [shortest, longest] = std::minmax_element(steps.begin(), steps.end());
    record->notices.push_back(
        fmt::format("samples are not equally spaced (steps of {:.4g} to {:.4g} ms)", 1e3 * *shortest, 1e3 * *longest));
    return;
  }
  const auto before = static_cast<std::size_t>(gap - steps.begin());
  const auto gaps = std::count_if(steps.begin(), steps.end(), is_gap);
  if (raw.header.samples_missing) {
    const double longest = *std::max_element(steps.begin(), steps.end());
    record->sampling_hz = SnapRate(1 / median);
    record->notices.push_back(fmt::format("samples are missing, as the record says: {} gap{} of up to {:.4g} ms", gaps,
                                          gaps == 1 ? "" : "s", 1e3 * longest));
    return;
  }
  std::string message = fmt::format(
      "expected a sample about {:.4g} ms after {:.6g} s, found the next one after {:.4g} ms (about {:.0f} missing); "
      "use the part before or after the gap, or give --rate HZ if only the time stamps are wrong",
      1e3 * median, t[before], 1e3 * *gap, *gap / median - 1);
  if (gaps > 1) message += fmt::format("; and {} more gap{} like it", gaps - 1, gaps == 2 ? "" : "s");
  throw InputError(file, raw.lines.LineOf(before + 1), message);
}

/// Time stamps within the rounding of their last printed decimal of an even grid are put on it.
void SetTimeFromColumn(RawRecord* raw, const std::string& file, Record* record) {
  RequireSeconds(*raw, file);
  RequireIncreasing(*raw, file);
  const std::vector<double>& t = raw->time;
  const double step = (t.back() - t.front()) / static_cast<double>(t.size() - 1);
  const double rounding = 1e-9 * step + 8e-16 * std::max(std::abs(t.front()), std::abs(t.back()));
  if (LargestDeviation(t, {t.front(), step}) <= rounding) {
    PutOnGrid(t.front(), SnapRate(1 / step), t.size(), record);
    return;
  }
  // Half a unit of the last decimal, and a tenth for the error of the fitted line itself.
  const double resolution = PrintedResolution(t);
  const Grid grid = FitGrid(t, raw->header.sampling_hz, 0.6 * resolution);
  if (LargestDeviation(t, grid) <= 0.6 * resolution) {
    record->notices.push_back(fmt::format("time stamps are rounded to {:g} ms; equal steps of {:.6g} ms assumed",
                                          1e3 * resolution, 1e3 * grid.step));
    PutOnGrid(grid.start, 1 / grid.step, t.size(), record);
    return;
  }
  record->uniform = false;
  record->sampling_hz = 1 / step;
  JudgeIrregularSteps(*raw, file, record);
  record->t = std::move(raw->time);
}

bool IsIncreasing(const std::vector<double>& t) {
  return std::adjacent_find(t.begin(), t.end(), [](double a, double b) { return b <= a; }) == t.end();
}

/// --rate beside a column that could be a time: use the rate, and say so where the two differ.
void CompareWithTimeColumn(const RawRecord& raw, double rate_hz, const std::string& file, Record* record) {
  if (raw.time.empty()) return;
  if (!IsIncreasing(raw.time)) {
    throw InputError(file, 0,
                     fmt::format("expected one displacement column with --rate, found {} columns without a time; say "
                                 "which one it is with --column N",
                                 raw.columns));
  }
  const auto measured = static_cast<double>(raw.time.size() - 1) / (raw.time.back() - raw.time.front());
  if (std::abs(measured - rate_hz) > 0.001 * rate_hz) {
    record->notices.push_back(
        fmt::format("column 1 is not used as time ({:g} samples per unit of it): --rate {:g}", measured, rate_hz));
  }
}

void SetTime(RawRecord* raw, const std::string& file, const ReadOptions& options, Record* record) {
  if (options.rate_hz) {
    CompareWithTimeColumn(*raw, *options.rate_hz, file, record);
    PutOnGrid(0, *options.rate_hz, raw->value.size(), record);
  } else if (!raw->time.empty()) {
    SetTimeFromColumn(raw, file, record);
    const double stated = raw->header.sampling_hz.value_or(record->sampling_hz);
    if (std::abs(stated - record->sampling_hz) > 0.001 * record->sampling_hz) {
      record->notices.push_back(fmt::format("the header says {:g} Hz, the time column {:g} Hz: the time column is used",
                                            stated, record->sampling_hz));
    }
  } else if (raw->header.sampling_hz) {
    PutOnGrid(0, *raw->header.sampling_hz, raw->value.size(), record);
  } else {
    throw InputError(file, raw->lines.LineOf(0),
                     "expected time and displacement, found one column; give the sampling rate with --rate HZ, or in "
                     "the file: \"# sampling_hz: HZ\"");
  }
}

// --- displacement --------------------------------------------------------------------------------------------------

Unit FindRecordUnit(const Header& header, const ReadOptions& options, const std::string& file) {
  if (options.displacement_unit) return *record_parts::FindUnit(*options.displacement_unit);
  if (header.unit) return *header.unit;
  if (header.column_unit) return *header.column_unit;
  if (header.unknown_unit.empty()) return *record_parts::FindUnit("mm");
  throw InputError(file, header.unknown_unit_line,
                   fmt::format("expected a displacement unit ({}), found {} in the column's name; convert the column, "
                               "or say its unit in the file: \"# displacement_unit: mm\"",
                               DisplacementUnits(), record_parts::Quote(header.unknown_unit)));
}

constexpr const char* kUnitAdvice = "is the unit right? Set it in the file, for example \"# displacement_unit: um\"";

void RequireBelievable(const RawRecord& raw, const Unit& unit, const std::string& file) {
  const auto too_large = [&](double v) { return std::abs(v) * unit.metres > kMaxDisplacement; };
  const auto first = std::find_if(raw.value.begin(), raw.value.end(), too_large);
  if (first == raw.value.end()) return;
  const auto count = std::count_if(first, raw.value.end(), too_large);
  std::string message = fmt::format("expected a displacement within +-{:g} {}, found {:g} {} ({})",
                                    kMaxDisplacement / unit.metres, unit.name, *first, unit.name, kUnitAdvice);
  if (count > 1) message += fmt::format("; and {} more line{} like it", count - 1, count == 2 ? "" : "s");
  throw InputError(file, raw.lines.LineOf(static_cast<std::size_t>(first - raw.value.begin())), message);
}

void RequireMotion(const RawRecord& raw, const Unit& unit, const std::string& file, Record* record) {
  const auto [low, high] = std::minmax_element(raw.value.begin(), raw.value.end());
  if (*low == *high) {
    throw InputError(
        file, raw.lines.LineOf(0),
        fmt::format("expected a displacement that moves, found {:g} {} in all {} samples; is column {} the "
                    "displacement (--column N), was the sensor connected?",
                    *low, unit.name, raw.value.size(), raw.value_column));
  }
  // The links of chapter 4 swing by 1 to 60 mm. Beyond a factor of ten or so the unit deserves a second look.
  const double swing = 0.5 * (*high - *low) * unit.metres;
  if (swing < 1e-4 || swing > 0.5) {
    record->notices.push_back(fmt::format("the record swings by +-{:.4g} mm: {}", 1e3 * swing, kUnitAdvice));
  }
  if (unit.angle) {
    record->notices.push_back(
        fmt::format("{} taken as displacement at a radius of 1 m (1 mrad counts as 1 mm)", unit.name));
  }
}

void SetDisplacement(RawRecord* raw, const std::string& file, const ReadOptions& options, Record* record) {
  const Unit unit = FindRecordUnit(raw->header, options, file);
  RequireBelievable(*raw, unit, file);
  RequireMotion(*raw, unit, file, record);
  if (raw->columns > 2 && !options.column && raw->uncertainty.empty()) {
    record->notices.push_back(
        fmt::format("column {} of {} is used as displacement (--column N)", raw->value_column, raw->columns));
  }
  for (double& value : raw->value) value *= unit.metres;
  record->y = std::move(raw->value);
  for (double& value : raw->uncertainty) value = std::abs(value) * unit.metres;
  record->uncertainty = std::move(raw->uncertainty);
}

// --- the measurement -------------------------------------------------------------------------------------------------

void SetMeasurement(const Header& header, const ReadOptions& options, Record* record) {
  record->direction = options.direction;
  if (!record->direction) record->direction = header.direction;
  if (!record->direction) record->direction = header.column_direction;
  const std::string name = std::filesystem::path(record->file).filename().string();
  const std::optional<Direction> in_name = record_parts::DirectionInName(name);
  if (!record->direction) record->direction = in_name;
  if (in_name && in_name != record->direction && !options.direction) {
    record->notices.push_back(fmt::format("taken as {}, as the file says, although its name says {}",
                                          Name(*record->direction), Name(*in_name)));
  }
  if (options.mass_kg || header.mass_kg) {
    record->mass_kg = options.mass_kg ? *options.mass_kg : *header.mass_kg;
  } else {
    record->notices.push_back(
        fmt::format("mass {:g} kg assumed (as in the thesis); the file has no \"# mass_kg:\"", record->mass_kg));
  }
  record->g = options.g.value_or(header.g.value_or(record->g));
  record->source = header.source;
}

Record Finish(RawRecord raw, const std::string& file, const ReadOptions& options) {
  if (raw.value.size() < kMinSamples) {
    throw InputError(file, raw.lines.LineOf(raw.value.size() - 1),
                     fmt::format("expected at least {} samples, found {}; is this the whole record?", kMinSamples,
                                 raw.value.size()));
  }
  Record record;
  record.file = file;
  record.notices = std::move(raw.header.notices);
  SetTime(&raw, file, options, &record);
  SetDisplacement(&raw, file, options, &record);
  SetMeasurement(raw.header, options, &record);
  return record;
}

void CheckOptions(const ReadOptions& options) {
  const auto require_positive = [](const std::optional<double>& value, const char* name) {
    if (value && !(*value > 0 && std::isfinite(*value))) {
      throw std::invalid_argument(fmt::format("ReadRecord: {} = {}, must be a number above 0", name, *value));
    }
  };
  require_positive(options.rate_hz, "rate_hz");
  require_positive(options.mass_kg, "mass_kg");
  require_positive(options.g, "g");
  if (options.column.value_or(1) < 1) {
    throw std::invalid_argument(fmt::format("ReadRecord: column = {}, must be 1 or more", *options.column));
  }
  if (options.displacement_unit && !record_parts::FindUnit(*options.displacement_unit)) {
    throw std::invalid_argument(fmt::format("ReadRecord: displacement_unit = {}, must be one of {}",
                                            *options.displacement_unit, DisplacementUnits()));
  }
}

// --- files -------------------------------------------------------------------------------------------------------

/// Beyond this a file is no ring-down: 1 GiB are 70 million samples.
constexpr std::uintmax_t kLargestFile = std::uintmax_t{1} << 30;

/// What must not be read to its end: huge files, and devices, which may have none.
void RefuseEndless(const std::filesystem::path& path, const std::string& file) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::is_character_file(status) || std::filesystem::is_block_file(status)) {
    throw InputError(file, 0, "expected a record, found a device");
  }
  if (!std::filesystem::is_regular_file(status)) return;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (!error && size > kLargestFile) {
    throw InputError(
        file, 0,
        fmt::format("expected a record, found {} MiB; records of more than {} MiB are not read, keep every "
                    "n-th sample",
                    size >> 20, kLargestFile >> 20));
  }
}

/// Levels 5 and 7.3 say what they are; level 4 has only its extension, which text files of `save -ascii` share.
bool IsMat(std::string_view text, const std::filesystem::path& path) {
  if (text.starts_with("MATLAB ")) return text.find("MAT-file") < 32;
  return record_parts::Lower(path.extension().string()) == ".mat" && text.find('\0') != std::string_view::npos;
}

}  // namespace

Record ParseRecord(std::string_view text, const std::string& file, const ReadOptions& options) {
  CheckOptions(options);
  return Finish(record_parts::ParseText(text, file, options), file, options);
}

Record ReadRecord(const std::filesystem::path& path, const ReadOptions& options) {
  CheckOptions(options);
  const std::string file = path.string();
  RefuseEndless(path, file);
  const std::string text = ReadFileWhole(path);
  if (IsMat(text, path)) return Finish(record_parts::ReadMat(path, file, options), file, options);
  return ParseRecord(text, file, options);
}

}  // namespace uiclink
