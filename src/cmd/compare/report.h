// The report of `lacquer compare`.
#pragma once

#include "cmd/report_page.h"

namespace lacquer::cmd {

/// The page's text (UTF-8). `results` is what results.json holds (docs/compare.md has the schema); the page
/// shows its numbers and embeds it whole. `images` may lack some that `results` names: the page says so
/// there. The boxes of `results` count pixels of the whole frame, of which images may be a part (their data
/// window). Every name and text of `results` is escaped. Cost and errors: as MakeReportPage().
std::string MakeCompareReport(const nlohmann::ordered_json& results, const std::vector<ReportImage>& images);

}  // namespace lacquer::cmd
