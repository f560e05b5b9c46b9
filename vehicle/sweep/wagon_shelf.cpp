#include "vehicle/sweep/wagon_shelf.h"

#include <fmt/format.h>

#include "data/checksum.h"
#include "vehicle/contact/profile.h"
#include "vehicle/hunting/set_scatter.h"
#include "vehicle/report_json.h"

namespace uiclink {
namespace {

std::string Key(const std::optional<double>& value) { return value ? fmt::format("{};", *value) : ";"; }

std::string BodyKey(const RunSetup& setup) {
  const InertiaOptions& inertia = setup.choice.inertia;
  return fmt::format("{};{};{};{}", setup.choice.wagon, setup.choice.cargo, Name(inertia.com),
                     Name(inertia.partitions));
}

std::string LinksKey(const RunSetup& setup) { return fmt::format("{}", fmt::join(setup.choice.sets, ";")); }

std::string TrackKey(const RunSetup& setup) {
  return fmt::format("{};{};", setup.choice.geometry, setup.choice.contact_table);
}

std::string TableKey(const RunSetup& setup) {
  return TrackKey(setup) + fmt::format("{};{};", setup.wheel_profile, setup.rail_profile) + Key(setup.gauge) +
         Key(setup.back_to_back) + Key(setup.rail_offset) + Key(setup.cant) + Key(setup.wheel_load);
}

std::string UndrawnKey(const RunSetup& setup) {
  const WagonOptions& options = setup.choice.options;
  return TableKey(setup) + "|" + BodyKey(setup) + "|" + LinksKey(setup) + "|" + Key(setup.lateral_clearance) +
         Key(setup.longitudinal_clearance) + Key(setup.lateral_stiffness) + Key(setup.longitudinal_stiffness) +
         fmt::format("{};{};{};{};{}", Name(options.suspension), Name(options.penetration), options.guidance,
                     options.mu, options.printed_roll);
}

std::string DrawKey(const RunSetup& setup) {
  return fmt::format("|{};{};{};{};{}", setup.draw_sets, setup.draw_corners, setup.scatter, setup.seed, setup.sample);
}

void Replace(const std::optional<double>& value, double* target) {
  if (value) *target = *value;
}

}  // namespace

std::string WagonShelf::Locate(const std::string& text) const {
  const bool is_path = text.find_first_of("/.") != std::string::npos;
  return is_path && std::filesystem::path(text).is_relative() ? (folder_ / text).lexically_normal().string() : text;
}

std::string WagonShelf::LocateSet(const std::string& text) const {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || text.substr(0, equals).find('/') != std::string::npos) return Locate(text);
  return text.substr(0, equals + 1) + Locate(text.substr(equals + 1));
}

WagonShelf::Part WagonShelf::Body(const RunSetup& setup) {
  return bodies_.Get(BodyKey(setup), [&] {
    WagonInputs inputs;
    inputs.choice = setup.choice;
    inputs.choice.wagon = Locate(setup.choice.wagon);
    inputs.choice.cargo = Locate(setup.choice.cargo);
    ReadWagonBody(inputs.choice, &inputs);
    return inputs;
  });
}

WagonShelf::Part WagonShelf::Links(const RunSetup& setup) {
  return links_.Get(LinksKey(setup), [&] {
    WagonInputs inputs;
    for (const std::string& set : setup.choice.sets) inputs.choice.sets.push_back(LocateSet(set));
    ReadWagonLinks(inputs.choice, &inputs);
    return inputs;
  });
}

WagonShelf::Part WagonShelf::Track(const RunSetup& setup) {
  return tracks_.Get(TrackKey(setup), [&] {
    WagonInputs inputs;
    inputs.choice.geometry = Locate(setup.choice.geometry);
    const std::string& table = setup.choice.contact_table;
    if (!table.empty()) inputs.choice.contact_table = (folder_ / table).string();  // an absolute one stays
    ReadWagonGeometry(inputs.choice, &inputs);
    return inputs;
  });
}

WagonShelf::Part WagonShelf::Table(const RunSetup& setup) {
  return tables_.Get(TableKey(setup), [&] {
    WagonInputs inputs = *Track(setup);
    if (inputs.geometry) {
      TrackGeometry& track = *inputs.geometry;
      if (!setup.wheel_profile.empty()) track.wheel = Locate(setup.wheel_profile);
      if (!setup.rail_profile.empty()) track.rail = Locate(setup.rail_profile);
      Replace(setup.gauge, &track.gauge);
      Replace(setup.back_to_back, &track.back_to_back);
      Replace(setup.rail_offset, &track.rail_offset);
      Replace(setup.cant, &track.cant);
      Replace(setup.wheel_load, &track.wheel_load);
    }
    MakeContactTable(&inputs);
    return inputs;
  });
}

std::vector<InputFile> WagonShelf::Files(const RunSetup& setup) {
  std::vector<InputFile> files = Body(setup)->files;
  const auto add = [&files](const std::vector<InputFile>& more) {
    files.insert(files.end(), more.begin(), more.end());
  };
  add(Links(setup)->files);
  for (const InputFile& file : Track(setup)->files) {
    const bool replaced = (file.role == "wheel_profile" && !setup.wheel_profile.empty()) ||
                          (file.role == "rail_profile" && !setup.rail_profile.empty());
    if (!replaced) files.push_back(file);
  }
  for (const auto& [role, profile] :
       {std::pair("wheel_profile", setup.wheel_profile), std::pair("rail_profile", setup.rail_profile)}) {
    if (profile.empty() || FindStandardProfile(profile) != nullptr) continue;
    files.push_back(*profiles_.Get(role + (":" + profile), [&, role = role, profile = profile] {
      const std::string path = Locate(profile);
      return InputFile{.role = role,
                       .name = std::filesystem::path(path).filename().string(),
                       .path = path,
                       .sha256 = CalcFileSha256(path)};
    }));
  }
  return files;
}

std::vector<std::string> WagonShelf::Notices(const RunSetup& setup) {
  std::vector<std::string> notices = Body(setup)->notices;
  const std::vector<std::string>& links = Links(setup)->notices;
  notices.insert(notices.end(), links.begin(), links.end());
  return notices;
}

std::shared_ptr<const std::vector<DrawnValue>> WagonShelf::Draws(const RunSetup& setup) {
  return draws_.Get(LinksKey(setup) + DrawKey(setup), [&] { return ListDraws(setup, Links(setup)->links); });
}

std::shared_ptr<const Wagon> WagonShelf::Get(const RunSetup& setup) {
  const auto undrawn = [&] { return undrawn_.Get(UndrawnKey(setup), [&] { return Make(setup); }); };
  if (!setup.DrawsLinks()) return undrawn();
  return wagons_.Get(UndrawnKey(setup) + DrawKey(setup),
                     [&] { return WithLinks(*undrawn(), DrawLinks(setup, Links(setup)->links)); });
}

Wagon WagonShelf::Make(const RunSetup& setup) {
  const Part body = Body(setup), links = Links(setup), track = Table(setup);
  WagonData data = body->data;
  Replace(setup.lateral_clearance, &data.guidance.lateral.clearance);
  Replace(setup.longitudinal_clearance, &data.guidance.longitudinal.clearance);
  Replace(setup.lateral_stiffness, &data.guidance.lateral.k);
  Replace(setup.longitudinal_stiffness, &data.guidance.longitudinal.k);
  return {data, body->body, body->loaded, links->links, track->table, setup.choice.options};
}

}  // namespace uiclink
