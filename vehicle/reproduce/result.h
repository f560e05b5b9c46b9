#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "vehicle/reproduce/item.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink::reproduce {

/// A number, a word, or nothing: what was looked for is not there (hunting that never sets in).
using Value = std::variant<std::monostate, double, std::string>;

struct Picture {
  std::string title;  ///< what it shows, for who cannot see it
  std::string svg;
  std::string chart = {};  ///< the same to zoom and read values from (reports/chart.h); empty: none
};

/// What came out of an item on one geometry.
struct ItemResult {
  std::map<std::string, Value> values;
  std::vector<Picture> pictures;
  std::vector<std::string> notices;  ///< what was left undone and why; a picture that could not be drawn
  std::string failure;               ///< why there is nothing else; empty: there is
  bool drawn = true;                 ///< every picture was
  double wall_s = 0;
};

/// Checksum of all that a result depends on: program, task, files. A result with another one is computed again.
std::string CalcKey(const Item& item, const Task& task, const WagonInputs& inputs);

/// Results in folder/results/GEOMETRY/ID.json, each written whole or not at all, schema "wagon-reproduce-item/1".
class ResultStore {
 public:
  explicit ResultStore(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// None where there is no such file, it has another key, or a picture is missing in it.
  std::optional<ItemResult> Read(const std::string& geometry, const std::string& id, const std::string& key) const;
  void Write(const std::string& geometry, const std::string& id, const std::string& key,
             const ItemResult& result) const;

 private:
  std::filesystem::path PathOf(const std::string& geometry, const std::string& id) const;
  std::filesystem::path folder_;
};

/// How theirs and ours stand to each other.
enum class Verdict {
  kMet,
  kExplained,
  kUnexplained,
  kOtherGeometry,  ///< on nominal-1435, whose critical speeds are a third of theirs: not looked into further
  kNotCompared,    ///< nothing is published
  kMissing,
};
inline constexpr std::size_t kVerdicts = 6;
const char* VerdictName(Verdict verdict);  ///< "met", ..., "other geometry", "-", "not computed"

struct Comparison {
  Verdict verdict = Verdict::kMissing;
  std::string ours = "-";
  std::string difference;  ///< "+2.5 %"; empty where theirs is no number
  std::string why;
};
/// @param result  null: not computed.
Comparison Compare(const Row& row, const std::string& geometry, const ItemResult* result);

}  // namespace uiclink::reproduce
