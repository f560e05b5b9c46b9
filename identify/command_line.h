#pragma once

#include <string>
#include <vector>

#include "identify/page/report_page.h"

namespace CLI {
class App;
}

namespace uiclink {

/// What a command line says, for the report: itself, quoted so that a shell takes it back, every option with its value
/// (the default where it was not given), and the files with their checksums.
Provenance DescribeCommandLine(int argc, const char* const* argv, const CLI::App& app,
                               const std::vector<std::string>& files);

}  // namespace uiclink
