#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/parameter_set.h"
#include "vehicle/contact/calc_contact_table.h"
#include "vehicle/contact/contact_table.h"
#include "vehicle/contact/geometry.h"
#include "vehicle/freight.h"
#include "vehicle/inertia.h"
#include "vehicle/wagon.h"
#include "vehicle/wagon_data.h"

namespace uiclink {

/// A command line that makes no sense. what() says what was expected.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The wagon that a user asks for, by names of files that come with the programs or by paths (data/data_path.h).
struct WagonChoice {
  /// Parameter sets, each FILE or WHERE=FILE with WHERE one of lateral, longitudinal; front, rear, front-left,
  /// front-right, rear-left, rear-right; or such a place with a direction, "front-left.lateral". The narrower place
  /// wins. What no set is given for comes from set1.
  std::vector<std::string> sets = {};
  std::string wagon = "hbbills311";
  std::string cargo = "empty";
  std::string geometry = "nominal-1435";
  std::string contact_table = {};  ///< a file instead of the geometry's own table; empty: none
  InertiaOptions inertia = {};
  WagonOptions options = {};
};

/// A file that a result stands on.
struct InputFile {
  std::string role;  ///< "wagon", "cargo", "geometry", "wheel_profile", "rail_profile", "contact_table", "set"
  std::string name;  ///< what the file calls itself
  std::string path;  ///< as the user gave it, or where it was found
  std::string sha256;
  std::vector<std::string> used_for = {};  ///< sets: "front_left.lateral", ...
};

/// Everything that a result stands on: what was asked for, what was read, and what has to be said about it.
struct WagonInputs {
  WagonChoice choice;
  std::vector<InputFile> files;
  WagonData data;
  Freight freight;
  BodyInertia body;
  bool loaded = false;  ///< there is freight: the loaded damping of the parabolic spring counts
  std::array<CornerLinks, kCorners> links;
  std::optional<TrackGeometry> geometry;      ///< where the contact table was not given as a file
  std::optional<ContactNotes> contact_notes;  ///< of the table that was made from it
  double contact_wall_s = 0;                  ///< time that making it took
  ContactTable table;
  std::vector<std::string> notices;  ///< directions without a set, effects left out, freight that stands out
};

/// "front_left", ..., in the order of corners.
extern const std::array<const char*, kCorners> kCornerNames;

/// The corners that a place of --set means: "front", "rear", "front-left", ...; none for another word.
std::optional<std::array<bool, kCorners>> FindCorners(const std::string& word);

/// Reads all files and computes contact table and inertia.
/// @throws InputError for a file that cannot be used, UsageError for a set whose place is unknown or taken twice.
WagonInputs ReadWagonInputs(const WagonChoice& choice);

/// The wagon of these inputs.
Wagon MakeWagon(const WagonInputs& inputs);

/// Parts of ReadWagonInputs, for commands that need no whole wagon. Each appends to `inputs`.
void ReadWagonFile(const WagonChoice& choice, WagonInputs* inputs);     ///< data
void ReadCargo(const WagonChoice& choice, WagonInputs* inputs);         ///< freight, body; ReadWagonFile first
void ReadWagonBody(const WagonChoice& choice, WagonInputs* inputs);     ///< both
void ReadWagonContact(const WagonChoice& choice, WagonInputs* inputs);  ///< geometry, table, its notes
/// The two halves of ReadWagonContact: the files alone (geometry, or a table that is given), and the table of a
/// geometry that a caller may have changed in between. @throws InputError where the wheelset does not fit between the
/// rails.
void ReadWagonGeometry(const WagonChoice& choice, WagonInputs* inputs);
void MakeContactTable(WagonInputs* inputs);  ///< table, notes; nothing where the table was given
void ReadWagonLinks(const WagonChoice& choice, WagonInputs* inputs);  ///< links
/// A parameter set by name or path, for a command that needs no more; its file is appended to `inputs`.
ParameterSet ReadSet(const std::string& name, WagonInputs* inputs);

}  // namespace uiclink
