#include "vehicle/sweep/sweep_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "data/checksum.h"

namespace uiclink {
namespace {

/// The axes whose values are files or stand beside them: with these it is settled which files a run has, and what is
/// drawn from them.
constexpr std::array kFileAxes{"geometry", "contact_table", "wheel_profile", "rail_profile",
                               "wagon",    "cargo",         "set",           "draw"};

std::string FilesKey(const RunSetup& setup) {
  return fmt::format("{}|{}|{}|{}|{}|{}|{}", setup.choice.geometry, setup.choice.contact_table, setup.wheel_profile,
                     setup.rail_profile, setup.choice.wagon, setup.choice.cargo, fmt::join(setup.choice.sets, ","));
}

bool IsFileAxis(std::size_t axis) { return std::ranges::find(kFileAxes, SweepAxes()[axis].name) != kFileAxes.end(); }

bool Same(const InputFile& a, const InputFile& b) { return a.role == b.role && a.path == b.path; }

void Apply(std::size_t axis, const AxisValue& value, RunSetup* setup) { SweepAxes()[axis].apply(value, setup); }

}  // namespace

SweepPlan::SweepPlan(Campaign campaign)
    : campaign_(std::move(campaign)), shelf_(std::make_shared<WagonShelf>(campaign_.folder)) {
  size_ = std::max(campaign_.samples, 1u);
  for (const Campaign::Grid& grid : campaign_.grid) size_ *= grid.values.size();
  ReadFiles();
}

SweepPlan::Place SweepPlan::Find(std::size_t run) const {
  Place place{.grid = std::vector<std::size_t>(campaign_.grid.size()), .sample = 0};
  // Motion axes are the last of the grid; the sample comes before them, since it may change the wagon.
  const auto take = [&run](std::size_t size) {
    const std::size_t digit = run % size;
    run /= size;
    return digit;
  };
  std::size_t i = campaign_.grid.size();
  for (; i > 0 && SweepAxes()[campaign_.grid[i - 1].axis].is_motion; --i)
    place.grid[i - 1] = take(campaign_.grid[i - 1].values.size());
  place.sample = static_cast<std::uint32_t>(take(std::max(campaign_.samples, 1u)));
  for (; i > 0; --i) place.grid[i - 1] = take(campaign_.grid[i - 1].values.size());
  return place;
}

std::uint64_t SweepPlan::Seed(const Place& place) const {
  if (!campaign_.own_draws) return campaign_.seed;
  std::string text = fmt::format("{}", campaign_.seed);
  for (std::size_t i = 0; i < place.grid.size(); ++i) {
    const Campaign::Grid& grid = campaign_.grid[i];
    text += fmt::format("|{}={}", SweepAxes()[grid.axis].name, FormatValue(grid.values[place.grid[i]]));
  }
  return std::stoull(CalcSha256(text).substr(0, 16), nullptr, 16);
}

std::vector<std::optional<AxisValue>> SweepPlan::Values(std::size_t run) const {
  const Place place = Find(run);
  std::vector<std::optional<AxisValue>> values = campaign_.base;
  for (std::size_t i = 0; i < place.grid.size(); ++i)
    values[campaign_.grid[i].axis] = campaign_.grid[i].values[place.grid[i]];
  const std::uint64_t seed = campaign_.sampled.empty() ? 0 : Seed(place);
  for (const Campaign::Sampled& sampled : campaign_.sampled) {
    values[sampled.axis] = sampled.distribution.Draw(CounterRandom(seed, place.sample, SweepAxes()[sampled.axis].name));
  }
  return values;
}

std::optional<std::uint32_t> SweepPlan::Sample(std::size_t run) const {
  if (campaign_.samples == 0) return std::nullopt;
  return Find(run).sample;
}

RunSetup SweepPlan::Setup(std::size_t run) const {
  const Place place = Find(run);
  RunSetup setup;
  setup.seed = Seed(place);
  setup.sample = place.sample;
  const std::vector<std::optional<AxisValue>> values = Values(run);
  for (std::size_t axis = 0; axis < values.size(); ++axis)
    if (values[axis]) Apply(axis, *values[axis], &setup);
  return setup;
}

std::string SweepPlan::Identity(std::size_t run) const {
  std::string text = "wagon-sweep/1\n" + campaign_.kind->Identity() + "\n";
  const std::vector<std::optional<AxisValue>> values = Values(run);
  for (std::size_t axis = 0; axis < values.size(); ++axis) {
    if (values[axis]) text += fmt::format("{}={}\n", SweepAxes()[axis].name, FormatValue(*values[axis]));
  }
  const RunSetup setup = Setup(run);
  if (campaign_.samples > 0 || setup.DrawsLinks()) text += fmt::format("sample={} seed={}\n", setup.sample, setup.seed);
  return text + FilesText(setup);
}

std::vector<std::optional<double>> SweepPlan::Drawn(std::size_t run) const {
  std::vector<std::optional<double>> values(drawn_columns_.size());
  if (values.empty()) return values;
  for (const DrawnValue& drawn : *shelf_->Draws(Setup(run))) {
    const auto column = std::ranges::find(drawn_columns_, drawn.column);
    values[static_cast<std::size_t>(column - drawn_columns_.begin())] = drawn.value;
  }
  return values;
}

std::string SweepPlan::Id(std::size_t run) const { return CalcSha256(Identity(run)); }

const std::string& SweepPlan::FilesText(const RunSetup& setup) const { return file_texts_.at(FilesKey(setup)); }

void SweepPlan::ReadFiles() {
  // Every combination of values of the file axes that the campaign can meet.
  std::vector<RunSetup> setups(1);
  const auto multiply = [&setups](std::size_t axis, const std::vector<AxisValue>& values) {
    std::vector<RunSetup> more;
    for (const RunSetup& setup : setups) {
      for (const AxisValue& value : values) Apply(axis, value, &more.emplace_back(setup));
    }
    setups = std::move(more);
  };
  for (std::size_t axis = 0; axis < campaign_.base.size(); ++axis)
    if (IsFileAxis(axis) && campaign_.base[axis]) multiply(axis, {*campaign_.base[axis]});
  for (const Campaign::Grid& grid : campaign_.grid)
    if (IsFileAxis(grid.axis)) multiply(grid.axis, grid.values);
  for (const Campaign::Sampled& sampled : campaign_.sampled)
    if (IsFileAxis(sampled.axis)) multiply(sampled.axis, sampled.distribution.choices);

  std::set<std::string> said;
  for (const RunSetup& setup : setups) {
    std::string text;
    for (const InputFile& file : shelf_->Files(setup)) {
      text += fmt::format("{}={} {}\n", file.role, file.sha256, fmt::join(file.used_for, ","));
      if (std::ranges::none_of(files_, [&](const InputFile& known) { return Same(known, file); }))
        files_.push_back(file);
    }
    file_texts_[FilesKey(setup)] = text;
    for (const std::string& notice : shelf_->Notices(setup))
      if (said.insert(notice).second) notices_.push_back(notice);
    for (const DrawnValue& drawn : *shelf_->Draws(setup)) {
      if (std::ranges::find(drawn_columns_, drawn.column) == drawn_columns_.end())
        drawn_columns_.push_back(drawn.column);
    }
  }
}

std::vector<std::size_t> SweepPlan::ShownAxes() const {
  static const std::set<std::string> always{"geometry", "cargo", "set", "speed", "start"};
  std::vector<std::size_t> shown;
  for (std::size_t axis = 0; axis < SweepAxes().size(); ++axis) {
    const SweepAxis& known = SweepAxes()[axis];
    const bool used = !known.is_motion || (known.is_start ? campaign_.kind->UsesStart() : campaign_.kind->UsesSpeed());
    const auto is_this = [axis](const auto& varied) { return varied.axis == axis; };
    const bool varies = std::ranges::any_of(campaign_.grid, is_this) || std::ranges::any_of(campaign_.sampled, is_this);
    if (used && (varies || campaign_.said[axis] || always.contains(known.name))) shown.push_back(axis);
  }
  return shown;
}

}  // namespace uiclink
