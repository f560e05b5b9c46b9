#include "vehicle/wagon_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <map>
#include <stdexcept>
#include <utility>

#include "data/checksum.h"
#include "data/data_path.h"
#include "data/file.h"
#include "data/input_error.h"
#include "data/parameter_set_file.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;

constexpr std::array kDirections{Direction::kLateral, Direction::kLongitudinal};
constexpr const char* kStandIn = "set1";  // where no set is given, or it lacks a direction

/// A file read once, so that the checksum is of what was used, and a pipe will do.
struct ReadText {
  fs::path path;
  std::string text;
};

ReadText Read(std::string_view subfolder, const std::string& name) {
  ReadText file{.path = FindDataFile(subfolder, name), .text = {}};
  file.text = ReadFileWhole(file.path);
  return file;
}

InputFile Describe(const std::string& role, const std::string& name, const ReadText& file) {
  return {.role = role, .name = name, .path = file.path.string(), .sha256 = CalcSha256(file.text)};
}

std::pair<ParameterSet, InputFile> ReadSetFile(const std::string& name) {
  const ReadText file = Read("parameter_sets", name);
  ParameterSet set = ParseParameterSet(file.text, file.path.string());
  InputFile described = Describe("set", set.name, file);
  return {std::move(set), std::move(described)};
}

// --- which set for which link --------------------------------------------------------------------------------------

/// The links that a set is given for, and the set.
struct SetPlace {
  std::array<bool, kCorners> corners{};
  std::array<bool, 2> directions{};
  std::string file;

  /// Links that it is given for: fewer are narrower.
  std::ptrdiff_t CountCorners() const { return std::ranges::count(corners, true); }
  std::ptrdiff_t CountDirections() const { return std::ranges::count(directions, true); }
};

/// Sets `corners` by a word; false if it is none of them.
bool TakeCorners(const std::string& word, SetPlace* place) {
  const auto corners = FindCorners(word);
  if (corners) place->corners = *corners;
  return corners.has_value();
}

bool TakeDirection(const std::string& word, SetPlace* place) {
  for (std::size_t d = 0; d < kDirections.size(); ++d) {
    if (word != Name(kDirections[d])) continue;
    place->directions = {d == 0, d == 1};
    return true;
  }
  return false;
}

SetPlace ParseSet(const std::string& text) {
  SetPlace place{.corners = {true, true, true, true}, .directions = {true, true}, .file = text};
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return place;
  const std::string where = text.substr(0, equals);
  if (where.find('/') != std::string::npos) return place;  // a path that has '=' in it
  place.file = text.substr(equals + 1);
  const std::size_t dot = where.find('.');
  const bool known = dot == std::string::npos
                         ? TakeDirection(where, &place) || TakeCorners(where, &place)
                         : TakeCorners(where.substr(0, dot), &place) && TakeDirection(where.substr(dot + 1), &place);
  if (known) return place;
  throw UsageError(fmt::format(
      "--set {}: expected lateral, longitudinal, front, rear, front-left, front-right, rear-left, rear-right, "
      "or such a place with a direction (front-left.lateral) before '=', found \"{}\"",
      text, where));
}

bool Overlap(const SetPlace& a, const SetPlace& b) {
  bool corner = false, direction = false;
  for (std::size_t i = 0; i < kCorners; ++i) corner |= a.corners[i] && b.corners[i];
  for (std::size_t i = 0; i < 2; ++i) direction |= a.directions[i] && b.directions[i];
  return corner && direction;
}

/// Wide places first, so that narrow ones overwrite them: by corners, then by directions.
std::vector<SetPlace> ParseSets(const std::vector<std::string>& texts) {
  std::vector<SetPlace> places;
  for (const std::string& text : texts) places.push_back(ParseSet(text));
  const auto key = [](const SetPlace& place) { return std::pair(-place.CountCorners(), -place.CountDirections()); };
  std::ranges::stable_sort(places, {}, key);
  for (std::size_t i = 1; i < places.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (key(places[i]) == key(places[j]) && Overlap(places[i], places[j]))
        throw UsageError(fmt::format("--set: expected one set for each place, found two: {} and {}", places[j].file,
                                     places[i].file));
    }
  }
  return places;
}

/// The sets in use, read once each, and what each is used for.
class SetLibrary {
 public:
  /// Index of a set by name or path.
  std::size_t Find(const std::string& name) {
    const auto [entry, is_new] = by_name_.try_emplace(name, sets_.size());
    if (is_new) {
      auto [set, file] = ReadSetFile(name);
      sets_.push_back(std::move(set));
      files_.push_back(std::move(file));
    }
    return entry->second;
  }

  const ParameterSet& set(std::size_t index) const { return sets_[index]; }
  InputFile& file(std::size_t index) { return files_[index]; }

  std::vector<InputFile> TakeUsed() {
    std::erase_if(files_, [](const InputFile& file) { return file.used_for.empty(); });
    return std::move(files_);
  }

 private:
  std::map<std::string, std::size_t> by_name_;
  std::deque<ParameterSet> sets_;  // references stay valid
  std::vector<InputFile> files_;
};

std::string LinkName(std::size_t corner, Direction direction) {
  return fmt::format("{}.{}", kCornerNames[corner], Name(direction));
}

/// The file that the user gave for a link; empty if none.
std::string ChosenFile(const std::vector<SetPlace>& places, std::size_t corner, std::size_t direction) {
  std::string file;
  for (const SetPlace& place : places) {
    if (place.corners[corner] && place.directions[direction]) file = place.file;
  }
  return file;
}

/// Links with the same reason share a notice.
class Notices {
 public:
  void Add(const std::string& reason, const std::string& link) { links_[reason].push_back(link); }
  void AppendTo(std::vector<std::string>* notices) const {
    for (const auto& [reason, links] : links_) {
      notices->push_back(fmt::format(
          "{} ({})", reason, links.size() == 2 * kCorners ? "all links" : fmt::format("{}", fmt::join(links, ", "))));
    }
  }

 private:
  std::map<std::string, std::vector<std::string>> links_;
};

/// Messages of the libraries below begin with the name of a function, which says nothing to a user.
std::string WithoutFunction(const std::string& message) {
  const std::size_t colon = message.find(": ");
  return colon == std::string::npos || message.find(' ') < colon ? message : message.substr(colon + 2);
}

/// What no set file can know of itself: effects, and whether sliders and effects have room beside each other.
void CheckLink(const DirectionParameters& parameters, double g, Direction direction, const std::string& file) {
  try {
    Link(parameters, g, 1.0);
  } catch (const std::invalid_argument& fault) {
    throw InputError(file, 0, fmt::format("[{}] {}", Name(direction), WithoutFunction(fault.what())));
  }
}

/// The set of one link, with what has to be said about it.
const ParameterSet& ChooseSet(const std::vector<SetPlace>& places, std::size_t corner, std::size_t direction,
                              SetLibrary* library, Notices* notices) {
  const std::string link = LinkName(corner, kDirections[direction]);
  const std::string chosen = ChosenFile(places, corner, direction);
  std::size_t index = library->Find(chosen.empty() ? kStandIn : chosen);
  if (!library->set(index)[kDirections[direction]]) {
    notices->Add(fmt::format("{} has no {} direction: it comes from {}", library->file(index).path,
                             Name(kDirections[direction]), kStandIn),
                 link);
    index = library->Find(kStandIn);
  } else if (chosen.empty() && !places.empty()) {
    notices->Add(fmt::format("no set is given: it comes from {}", kStandIn), link);
  }
  library->file(index).used_for.push_back(link);
  CheckLink(*library->set(index)[kDirections[direction]], library->set(index).g, kDirections[direction],
            library->file(index).path);
  for (const std::string& effect : EffectsLeftOut(*library->set(index)[kDirections[direction]])) {
    notices->Add(
        fmt::format("effect {} of {} has no place on a wagon and is left out", effect, library->file(index).path),
        link);
  }
  return library->set(index);
}

/// A file of points; the contact table reads it by itself.
void DescribeProfile(const std::string& role, const std::string& profile, WagonInputs* inputs) {
  if (FindStandardProfile(profile) != nullptr) return;
  const std::string name = fs::path(profile).filename().string();
  inputs->files.push_back({.role = role, .name = name, .path = profile, .sha256 = CalcFileSha256(profile)});
}

/// A contact table in other units, or one in which the flanges stand on the rails, would be taken for a wagon.
void CheckTable(const ContactTable& table, const std::string& file) {
  constexpr double kNarrowest = 1e-4, kWidest = 0.2;  // [m]
  constexpr double kTread = 8e-3;                     // [m] a flange root's radius differs by more
  const auto fail = [&](const std::string& message) { throw InputError(file, 0, message); };
  const double reach = std::min(-table.rows.front().y, table.rows.back().y);
  if (reach < kNarrowest || std::max(-table.rows.front().y, table.rows.back().y) > kWidest) {
    fail(fmt::format("expected y from 0.1 mm to 200 mm to either side, found {:g} m to {:g} m", table.rows.front().y,
                     table.rows.back().y));
  }
  for (const ContactRow& row : table.rows) {
    const auto check = [&](const char* name, double value, double low, double high) {
      if (!(low <= value && value <= high))
        fail(fmt::format("expected {} from {:g} to {:g}, found {:g} at y = {:g} m", name, low, high, value, row.y));
    };
    check("r [m]", row.r, 0.5 * table.r0, 2 * table.r0);
    for (const double c : {row.c11, row.c22, std::abs(row.c23)}) check("Kalker's coefficients", c, 0, 1e3);
    for (const double axis : {row.a_e, row.b_e}) check("semi-axes of contact [m]", axis, 1e-7, 0.1);
    check("q0 [m]", row.q0, 1e-9, 0.01);
    check("n0 [N]", row.n0, 0.1, 1e9);
  }
  const auto middle = std::ranges::min_element(table.rows, {}, [](const ContactRow& row) { return std::abs(row.y); });
  if (std::abs(middle->r - table.r0) > kTread) {
    fail(
        fmt::format("expected wheels that stand on their treads in the middle of the track, found them on a rolling "
                    "radius of {:.1f} mm, r0 = {:.1f} mm: the wheelset does not fit between the rails",
                    1e3 * middle->r, 1e3 * table.r0));
  }
}

/// What a track takes: more is said, and computed.
void NoteAxleLoad(WagonInputs* inputs) {
  constexpr double kMostTonnes = 22.5;  // UIC line class D
  const BodyInertia& body = inputs->body;
  const double heaviest = 0.5 * body.m * (1 + std::abs(body.x) / inputs->data.l) + inputs->data.wheelset.m;
  if (1e-3 * heaviest <= kMostTonnes) return;
  inputs->notices.push_back(fmt::format("{} makes an axle load of {:.1f} t; lines of class D take {} t",
                                        inputs->freight.name, 1e-3 * heaviest, kMostTonnes));
}

}  // namespace

const std::array<const char*, kCorners> kCornerNames{"front_left", "front_right", "rear_left", "rear_right"};

std::optional<std::array<bool, kCorners>> FindCorners(const std::string& word) {
  static const std::map<std::string, std::array<bool, kCorners>> words{
      {"front", {true, true, false, false}},       {"rear", {false, false, true, true}},
      {"front-left", {true, false, false, false}}, {"front-right", {false, true, false, false}},
      {"rear-left", {false, false, true, false}},  {"rear-right", {false, false, false, true}}};
  const auto found = words.find(word);
  return found != words.end() ? std::optional(found->second) : std::nullopt;
}

void ReadWagonFile(const WagonChoice& choice, WagonInputs* inputs) {
  const ReadText wagon = Read("wagons", choice.wagon);
  inputs->data = ParseWagonData(wagon.text, wagon.path.string());
  inputs->files.push_back(Describe("wagon", inputs->data.name, wagon));
}

void ReadCargo(const WagonChoice& choice, WagonInputs* inputs) {
  const ReadText cargo = Read("freight", choice.cargo);
  inputs->freight = ParseFreight(cargo.text, cargo.path.string());
  inputs->files.push_back(Describe("cargo", inputs->freight.name, cargo));
  inputs->loaded = inputs->freight.even.has_value() || !inputs->freight.boxes.empty();
  inputs->body = CalcBodyInertia(inputs->data, inputs->freight, choice.inertia);
  for (const std::string& notice : CheckFreight(inputs->freight, inputs->data.cargo)) inputs->notices.push_back(notice);
  NoteAxleLoad(inputs);
}

void ReadWagonBody(const WagonChoice& choice, WagonInputs* inputs) {
  ReadWagonFile(choice, inputs);
  ReadCargo(choice, inputs);
}

void ReadWagonGeometry(const WagonChoice& choice, WagonInputs* inputs) {
  if (!choice.contact_table.empty()) {
    const ReadText file{.path = choice.contact_table, .text = ReadFileWhole(choice.contact_table)};
    inputs->table = ParseContactTable(file.text, file.path.string());
    inputs->files.push_back(Describe("contact_table", inputs->table.name, file));
    CheckTable(inputs->table, file.path.string());
    return;
  }
  const ReadText file = Read("geometry", choice.geometry);
  inputs->geometry = ParseTrackGeometry(file.text, file.path);
  inputs->files.push_back(Describe("geometry", inputs->geometry->name, file));
  DescribeProfile("wheel_profile", inputs->geometry->wheel, inputs);
  DescribeProfile("rail_profile", inputs->geometry->rail, inputs);
}

void MakeContactTable(WagonInputs* inputs) {
  if (!inputs->geometry) return;
  const auto file = std::ranges::find(inputs->files, "geometry", &InputFile::role);
  const std::string path = file == inputs->files.end() ? inputs->geometry->name : file->path;
  const auto begin = std::chrono::steady_clock::now();
  try {
    inputs->table = CalcContactTable(*inputs->geometry, inputs->contact_notes.emplace());
  } catch (const std::invalid_argument& fault) {
    throw InputError(path, 0, WithoutFunction(fault.what()));
  }
  CheckTable(inputs->table, path);
  inputs->contact_wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void ReadWagonContact(const WagonChoice& choice, WagonInputs* inputs) {
  ReadWagonGeometry(choice, inputs);
  MakeContactTable(inputs);
}

void ReadWagonLinks(const WagonChoice& choice, WagonInputs* inputs) {
  const std::vector<SetPlace> places = ParseSets(choice.sets);
  SetLibrary library;
  Notices notices;
  for (std::size_t corner = 0; corner < kCorners; ++corner) {
    const ParameterSet& lateral = ChooseSet(places, corner, 0, &library, &notices);
    inputs->links[corner].lateral = *lateral.lateral;
    inputs->links[corner].g = lateral.g;
    const ParameterSet& longitudinal = ChooseSet(places, corner, 1, &library, &notices);
    inputs->links[corner].longitudinal = *longitudinal.longitudinal;
  }
  notices.AppendTo(&inputs->notices);
  for (InputFile& file : library.TakeUsed()) inputs->files.push_back(std::move(file));
}

ParameterSet ReadSet(const std::string& name, WagonInputs* inputs) {
  auto [set, file] = ReadSetFile(name);
  inputs->files.push_back(std::move(file));
  return std::move(set);
}

WagonInputs ReadWagonInputs(const WagonChoice& choice) {
  WagonInputs inputs;
  inputs.choice = choice;
  ReadWagonBody(choice, &inputs);
  ReadWagonLinks(choice, &inputs);
  ReadWagonContact(choice, &inputs);
  return inputs;
}

Wagon MakeWagon(const WagonInputs& inputs) {
  return {inputs.data, inputs.body, inputs.loaded, inputs.links, inputs.table, inputs.choice.options};
}

}  // namespace uiclink
