#pragma once

#include <filesystem>
#include <string>

#include "vehicle/page/wagon_book.h"
#include "vehicle/sweep/sweep_plan.h"

namespace uiclink {

/// The page of `wagon sweep`: the results of a store against what its campaign varies. The numeric axis with the most
/// values is drawn to the right, one with a few as curves, others as panels beside each other; of samples the median
/// and the range of 95 %.
/// @param file  of the campaign.
/// @throws InputError, SqliteError for a store that cannot be read.
std::string ComposeSweepPage(const SweepPlan& plan, const std::filesystem::path& file,
                             const std::filesystem::path& store, const PageOrigin& origin);

}  // namespace uiclink
