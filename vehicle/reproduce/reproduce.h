#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "vehicle/reproduce/item.h"
#include "vehicle/reproduce/result.h"

namespace uiclink::reproduce {

struct ReproduceProgress {
  std::size_t done = 0, total = 0;   ///< items, those that were there already included
  std::vector<std::string> running;  ///< "fig-10.1a on nominal-1435"
  double left_s = 0;                 ///< at the pace so far; 0: not known yet
};

struct ReproduceOptions {
  std::filesystem::path folder = "out/reproduce";
  std::vector<std::string> geometries = {"thesis-equivalent", "nominal-1435"};
  std::vector<std::string> only = {};      ///< ids of items; empty: all
  std::vector<std::string> sections = {};  ///< empty: all
  bool quick = false;                      ///< Quicken
  bool again = false;                      ///< results that are there do not count
  int threads = 0;                         ///< 0: all cores
  std::function<bool()> go_on = {};        ///< asked a few times a second by every item; false: stop. May be null
  std::function<void(const ReproduceProgress&)> on_progress = {};  ///< five times a second. May be null
};

/// Items by geometry: what was asked for, what there is.
struct Reproduction {
  std::vector<std::string> geometries;
  std::vector<const Item*> items;                                     ///< asked for, in the order of the chapter
  std::map<std::pair<std::string, std::string>, ItemResult> results;  ///< by geometry and id
  /// Places and contact of each geometry as used, in words.
  std::map<std::string, std::string> geometry_words;
  std::size_t computed = 0;  ///< by this call
  bool quick = false, interrupted = false;
  double wall_s = 0;

  const ItemResult* Find(const std::string& geometry, const std::string& id) const;
};

/// The items that are asked for. An item is named by its id or by a figure or table that it covers, "10.9".
/// @throws UsageError for a name that none has.
std::vector<const Item*> SelectItems(const ReproduceOptions& options);

/// Does every item on every geometry that the folder has no result for, longest first, on all cores. Each result is
/// written as it is finished, so that a run that is stopped or killed loses what is in hand and nothing else.
/// @throws UsageError, InputError.
Reproduction Reproduce(const ReproduceOptions& options);

/// How many rows are met, explained, ..., by geometry: in the order of Verdict.
std::vector<std::size_t> CountVerdicts(const Reproduction& reproduction, const std::string& geometry);

}  // namespace uiclink::reproduce
