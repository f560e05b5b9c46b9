// MATLAB files: which of their variables are the record.

#include <H5Epublic.h>
#include <fmt/format.h>
#include <matio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <span>

#include "data/input_error.h"
#include "identify/record_parts.h"

namespace uiclink::record_parts {
namespace {

/// A numeric variable, samples along time; `values` is stored channel by channel.
struct Series {
  std::string name;
  std::size_t samples = 0;
  std::size_t channels = 0;
  std::vector<double> values;

  std::span<const double> Channel(std::size_t channel) const { return {values.data() + channel * samples, samples}; }
};

/// Everything that a file holds and we can use.
struct Contents {
  std::vector<Series> series;
  Header header;
  std::vector<std::string> unused;  ///< what else is in the file, for messages: "model (function handle)"
};

// --- matio ---------------------------------------------------------------------------------------------------------

struct Close {
  void operator()(mat_t* file) const { Mat_Close(file); }
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};

/// HDF5, which matio reads level 7.3 with, prints its errors by itself. Quiet as long as this lives.
class QuietHdf5 {
 public:
  QuietHdf5() {
    H5Eget_auto2(H5E_DEFAULT, &print_, &stream_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~QuietHdf5() { H5Eset_auto2(H5E_DEFAULT, print_, stream_); }
  QuietHdf5(const QuietHdf5&) = delete;
  QuietHdf5& operator=(const QuietHdf5&) = delete;

 private:
  H5E_auto2_t print_ = nullptr;
  void* stream_ = nullptr;
};

template <typename T>
void Append(const matvar_t& variable, std::size_t count, std::vector<double>* out) {
  const T* data = static_cast<const T*>(variable.data);
  out->insert(out->end(), data, data + count);
}

/// The values of a real numeric array; false for anything else.
bool AppendValues(const matvar_t& variable, std::size_t count, std::vector<double>* out) {
  if (variable.isComplex || variable.data == nullptr) return false;
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
      Append<double>(variable, count, out);
      return true;
    case MAT_C_SINGLE:
      Append<float>(variable, count, out);
      return true;
    case MAT_C_INT8:
      Append<std::int8_t>(variable, count, out);
      return true;
    case MAT_C_UINT8:
      Append<std::uint8_t>(variable, count, out);
      return true;
    case MAT_C_INT16:
      Append<std::int16_t>(variable, count, out);
      return true;
    case MAT_C_UINT16:
      Append<std::uint16_t>(variable, count, out);
      return true;
    case MAT_C_INT32:
      Append<std::int32_t>(variable, count, out);
      return true;
    case MAT_C_UINT32:
      Append<std::uint32_t>(variable, count, out);
      return true;
    default:
      return false;
  }
}

/// Number of elements of a matrix, 0 for higher ranks and for sizes that the data do not back.
std::size_t ElementCount(const matvar_t& variable) {
  if (variable.rank != 2 || variable.data_size <= 0) return 0;
  const std::size_t count = variable.dims[0] * variable.dims[1];
  return variable.nbytes == count * static_cast<std::size_t>(variable.data_size) ? count : 0;
}

/// A numeric matrix with time along its longer side.
std::optional<Series> ToSeries(const matvar_t& variable, const std::string& name) {
  const std::size_t count = ElementCount(variable);
  if (count == 0) return std::nullopt;
  Series series{.name = name, .samples = variable.dims[0], .channels = variable.dims[1], .values = {}};
  series.values.reserve(count);
  if (!AppendValues(variable, count, &series.values)) return std::nullopt;
  if (series.samples >= series.channels) return series;
  std::swap(series.samples, series.channels);
  std::vector<double> turned(count);
  for (std::size_t i = 0; i < count; ++i) {
    turned[(i % series.channels) * series.samples + i / series.channels] = series.values[i];
  }
  series.values = std::move(turned);
  return series;
}

/// Pieces of one run in a cell array, put end to end. Empty unless all pieces are series of as many channels.
std::optional<Series> JoinCells(const matvar_t& variable, const std::string& name) {
  const std::size_t count = ElementCount(variable);
  auto* const* cells = static_cast<matvar_t* const*>(variable.data);
  if (count == 0 || cells == nullptr) return std::nullopt;
  std::vector<Series> pieces;
  for (std::size_t i = 0; i < count; ++i) {
    std::optional<Series> piece = cells[i] ? ToSeries(*cells[i], name) : std::nullopt;
    if (!piece || (!pieces.empty() && piece->channels != pieces.front().channels)) return std::nullopt;
    pieces.push_back(std::move(*piece));
  }
  Series joined{.name = name, .samples = 0, .channels = pieces.front().channels, .values = {}};
  for (const Series& piece : pieces) joined.samples += piece.samples;
  for (std::size_t channel = 0; channel < joined.channels; ++channel) {
    for (const Series& piece : pieces) {
      const std::span<const double> values = piece.Channel(channel);
      joined.values.insert(joined.values.end(), values.begin(), values.end());
    }
  }
  return joined;
}

std::optional<std::string> ToString(const matvar_t& variable) {
  const std::size_t count = ElementCount(variable);
  if (variable.class_type != MAT_C_CHAR || variable.data == nullptr || count == 0 || variable.dims[0] != 1) {
    return std::nullopt;
  }
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    const unsigned code = variable.data_size == 1 ? static_cast<const std::uint8_t*>(variable.data)[i]
                                                  : static_cast<const std::uint16_t*>(variable.data)[i];
    text += code < 0x80 ? static_cast<char>(code) : '?';
  }
  return text;
}

std::string LastName(std::string_view name) { return Lower(name.substr(name.rfind('.') + 1)); }

/// Scalars and strings that are header keys. A sampling interval counts as a rate.
void TakeHeader(std::string_view name, std::string_view value, const std::string& file, Header* header) {
  const std::string key = LastName(name);
  if (key == "dt" || key == "ts") {
    const std::optional<double> step = ParseNumber(value);
    if (step && *step > 0) header->sampling_hz = 1 / *step;
  } else {
    SetHeaderKey(key, value, file, 0, header);
  }
}

void Take(const matvar_t& variable, const std::string& name, int depth, const std::string& file, Contents* contents);

void TakeStruct(const matvar_t& variable, const std::string& name, int depth, const std::string& file,
                Contents* contents) {
  const unsigned fields = Mat_VarGetNumberOfFields(const_cast<matvar_t*>(&variable));
  char* const* names = Mat_VarGetStructFieldnames(&variable);
  for (unsigned i = 0; i < fields && names != nullptr; ++i) {
    const matvar_t* field = Mat_VarGetStructFieldByIndex(const_cast<matvar_t*>(&variable), i, 0);
    if (field != nullptr) Take(*field, name + "." + names[i], depth + 1, file, contents);
  }
}

void Take(const matvar_t& variable, const std::string& name, int depth, const std::string& file, Contents* contents) {
  constexpr int kDeepest = 4;  // "out.signals.values" and one to spare
  const bool single = variable.rank == 2 && variable.dims[0] == 1 && variable.dims[1] == 1;
  if (variable.class_type == MAT_C_STRUCT && single && depth < kDeepest) {
    TakeStruct(variable, name, depth, file, contents);
  } else if (std::optional<std::string> text = ToString(variable)) {
    TakeHeader(name, *text, file, &contents->header);
  } else if (std::optional<Series> series =
                 variable.class_type == MAT_C_CELL ? JoinCells(variable, name) : ToSeries(variable, name)) {
    if (series->values.size() == 1) {
      TakeHeader(name, fmt::format("{}", series->values[0]), file, &contents->header);
    } else {
      contents->series.push_back(std::move(*series));
    }
  } else {
    contents->unused.push_back(name);
  }
}

/// matio allocates whatever size a file claims, so a damaged one could fill the memory before it is found out.
void RequireBelievableSize(const matvar_t& variable, const std::string& file) {
  constexpr double kMostElements = 1.3e8;  // 1 GiB of doubles
  double elements = 1;
  for (int i = 0; i < variable.rank && variable.dims != nullptr; ++i) elements *= static_cast<double>(variable.dims[i]);
  if (elements <= kMostElements) return;
  throw InputError(file, 0,
                   fmt::format("expected a record, found a variable {} of {:.2g} elements (damaged?)",
                               Quote(variable.name ? variable.name : "?"), elements));
}

Contents ReadContents(const std::filesystem::path& path, const std::string& file) {
  const QuietHdf5 quiet;
  const std::unique_ptr<mat_t, Close> mat(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
  if (!mat) throw InputError(file, 0, "expected a MATLAB file, found one that matio cannot open (damaged?)");
  Contents contents;
  while (const std::unique_ptr<matvar_t, Close> variable{Mat_VarReadNextInfo(mat.get())}) {
    RequireBelievableSize(*variable, file);
    const std::string name = variable->name ? variable->name : "?";
    if (Mat_VarReadDataAll(mat.get(), variable.get()) == 0) {
      Take(*variable, name, 0, file, &contents);
    } else {
      contents.unused.push_back(name + " (unreadable)");
    }
  }
  if (contents.series.empty() && contents.unused.empty()) {
    throw InputError(file, 0, "expected a MATLAB file with a record, found no variable that can be read (damaged?)");
  }
  return contents;
}

// --- which variables are the record --------------------------------------------------------------------------------

/// "y (3000 x 1), model": what the file holds, for messages.
std::string Describe(const Contents& contents) {
  std::string list;
  for (const Series& s : contents.series) {
    list += fmt::format("{}{} ({} x {})", list.empty() ? "" : ", ", s.name, s.samples, s.channels);
  }
  for (const std::string& name : contents.unused) list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? "no variables" : list;
}

bool IsIncreasing(std::span<const double> t) {
  return std::adjacent_find(t.begin(), t.end(), [](double a, double b) { return !(b > a); }) == t.end();
}

/// "t", "t2", "time", "Time_id", "tout", "s.time": how people call a time vector.
bool IsTimeName(std::string_view name) {
  const std::string last = LastName(name);
  return last.find("time") != std::string::npos || last == "t" || last == "tout" ||
         (last.size() > 1 && last[0] == 't' && (last[1] == '_' || (last[1] >= '0' && last[1] <= '9')));
}

bool IsDisplacementName(std::string_view name) {
  const std::string last = LastName(name);
  if (DirectionInName(last)) return true;
  for (const std::string_view word : {"y", "x", "u", "disp", "displacement", "pos", "position", "data", "values"}) {
    if (last == word || last.starts_with(std::string(word) + "_")) return true;
  }
  return last.starts_with("displacement");
}

bool IsTime(const Series& s) { return s.channels == 1 && IsTimeName(s.name); }

/// What follows the last '_' or the first digit: "Time_id" and "Y_id" belong together, so do t2 and y2.
std::string Suffix(std::string_view name) {
  const std::size_t at = name.find_first_of("_0123456789");
  return at == std::string_view::npos ? "" : std::string(name.substr(at));
}

/// A time vector and the series of the same length, in the order of the file.
struct Run {
  const Series* time = nullptr;
  std::vector<const Series*> series;
};

/// Series as long as `time`; where several runs are as long, those with its suffix.
Run FindRun(const Series& time, const Contents& contents) {
  Run run{.time = &time, .series = {}};
  bool rival = false;
  for (const Series& s : contents.series) {
    if (s.samples != time.samples || &s == &time) continue;
    if (IsTime(s)) {
      rival = true;
    } else {
      run.series.push_back(&s);
    }
  }
  if (rival) std::erase_if(run.series, [&](const Series* s) { return Suffix(s->name) != Suffix(time.name); });
  return run;
}

std::size_t ChannelCount(const Run& run) {
  return std::accumulate(run.series.begin(), run.series.end(), std::size_t{0},
                         [](std::size_t sum, const Series* s) { return sum + s->channels; });
}

/// Column of the displacement, 1 = time: the only series, or the only one with a telling name. 0: cannot tell.
int DefaultColumn(const Run& run) {
  int found = 0;
  int column = 2;
  for (const Series* s : run.series) {
    if (run.series.size() == 1 || IsDisplacementName(s->name)) {
      if (found > 0) return 0;
      found = column;
    }
    column += static_cast<int>(s->channels);
  }
  return found;
}

[[noreturn]] void ThrowAmbiguous(const Run& run, const std::string& file) {
  std::string list;
  int column = 1;
  for (const Series* s : run.series) {
    for (std::size_t channel = 0; channel < s->channels; ++channel) {
      list += fmt::format("{}{} {}", list.empty() ? "" : ", ", ++column, s->name);
    }
  }
  throw InputError(file, 0,
                   fmt::format("expected one displacement beside the time {}, found {}; choose with --column N",
                               run.time->name, list));
}

void AppendRun(const Run& run, int column, Header* header, RawRecord* raw) {
  const std::span<const double> time = run.time->Channel(0);
  raw->time.insert(raw->time.end(), time.begin(), time.end());
  int first = 2;
  for (const Series* s : run.series) {
    const int channel = column - first;
    if (channel >= 0 && channel < static_cast<int>(s->channels)) {
      const std::span<const double> values = s->Channel(static_cast<std::size_t>(channel));
      raw->value.insert(raw->value.end(), values.begin(), values.end());
      header->column_direction = DirectionInName(s->name);
    }
    first += static_cast<int>(s->channels);
  }
}

/// Runs in the order of time; a fault unless each goes on where the one before ends (within one step and a half).
void RequireOneRun(std::vector<Run>* runs, const Contents& contents, const std::string& file) {
  std::sort(runs->begin(), runs->end(),
            [](const Run& a, const Run& b) { return a.time->values.front() < b.time->values.front(); });
  for (std::size_t i = 1; i < runs->size(); ++i) {
    const std::vector<double>& before = (*runs)[i - 1].time->values;
    const double step = before.back() - before[before.size() - 2];
    const double pause = (*runs)[i].time->values.front() - before.back();
    if (!(pause > 0 && pause <= 1.5 * step) || ChannelCount((*runs)[i]) != ChannelCount((*runs)[0])) {
      throw InputError(file, 0,
                       fmt::format("expected one run, found several that do not follow each other: {}; save one run "
                                   "per file",
                                   Describe(contents)));
    }
  }
}

/// Time vectors with their series. Several that follow each other are one record cut in pieces.
RawRecord ReadRuns(std::vector<Run> runs, Contents* contents, const ReadOptions& options, const std::string& file) {
  RequireOneRun(&runs, *contents, file);
  RawRecord raw;
  raw.columns = 1 + static_cast<int>(ChannelCount(runs.front()));
  raw.value_column = options.column ? ChooseColumns(raw.columns, options, file, 0).value : DefaultColumn(runs.front());
  if (raw.value_column == 0) ThrowAmbiguous(runs.front(), file);
  if (raw.value_column == 1) {
    throw InputError(file, 0,
                     fmt::format("expected a displacement, found the time {} in column 1", runs[0].time->name));
  }
  for (const Run& run : runs) AppendRun(run, raw.value_column, &contents->header, &raw);
  if (runs.size() > 1) {
    contents->header.notices.push_back(
        fmt::format("{} runs that follow each other are joined: {}", runs.size(), Describe(*contents)));
  }
  return raw;
}

/// The one matrix with time in its first column.
RawRecord ReadMatrix(const Series& matrix, const ReadOptions& options, const std::string& file) {
  const ColumnChoice choice = ChooseColumns(static_cast<int>(matrix.channels), options, file, 0);
  RawRecord raw;
  raw.columns = static_cast<int>(matrix.channels);
  raw.value_column = choice.value;
  const auto column = [&](int number) {
    const std::span<const double> values = matrix.Channel(static_cast<std::size_t>(number - 1));
    return std::vector<double>(values.begin(), values.end());
  };
  if (choice.time > 0) raw.time = column(choice.time);
  raw.value = column(choice.value);
  return raw;
}

/// The series to read where the file has no time vector: the only one, or the only one with a telling name.
const Series& FindOnlySeries(const Contents& contents, const std::string& file) {
  if (contents.series.size() == 1) return contents.series.front();
  const auto named = [](const Series& s) { return IsDisplacementName(s.name); };
  const auto found = std::find_if(contents.series.begin(), contents.series.end(), named);
  if (std::count_if(contents.series.begin(), contents.series.end(), named) == 1) return *found;
  throw InputError(file, 0,
                   fmt::format("expected a matrix of time and displacement, or vectors t and y of the same length, "
                               "found {}; rename them or save only these",
                               Describe(contents)));
}

RawRecord Choose(Contents* contents, const ReadOptions& options, const std::string& file) {
  std::vector<Run> runs;
  for (const Series& s : contents->series) {
    if (!IsTime(s) || !IsIncreasing(s.Channel(0)) || s.samples < 2) continue;
    Run run = FindRun(s, *contents);
    if (!run.series.empty()) runs.push_back(std::move(run));
  }
  if (!runs.empty()) return ReadRuns(std::move(runs), contents, options, file);
  return ReadMatrix(FindOnlySeries(*contents, file), options, file);
}

void RequireFinite(const RawRecord& raw, const std::string& file) {
  for (const std::vector<double>* values : {&raw.time, &raw.value}) {
    const auto bad = [](double v) { return !std::isfinite(v); };
    const auto first = std::find_if(values->begin(), values->end(), bad);
    if (first == values->end()) continue;
    throw InputError(
        file, 0,
        fmt::format("expected numbers, found {} at sample {} of {} ({} in all); cut or interpolate them", *first,
                    first - values->begin() + 1, values->size(), std::count_if(first, values->end(), bad)));
  }
}

}  // namespace

RawRecord ReadMat(const std::filesystem::path& path, const std::string& file, const ReadOptions& options) {
  Contents contents = ReadContents(path, file);
  RawRecord raw = Choose(&contents, options, file);
  RequireFinite(raw, file);
  raw.header = std::move(contents.header);
  return raw;
}

}  // namespace uiclink::record_parts
