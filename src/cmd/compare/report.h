// The report of `lacquer compare`: one HTML page that needs no other file and no network.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pbrt/image/image.h"

namespace lacquer::cmd {

/// One image of the page.
struct ReportImage {
    std::string file;              ///< its path as results.json has it
    const Image* image = nullptr;  ///< RGB, or one channel (a map of errors); alive while the page is made
};

/// The page's text (UTF-8). `results` is what results.json holds (docs/compare.md has the schema); the page
/// shows its numbers and embeds it whole. `images` may lack some that `results` names: the page says so
/// there. Pixels keep 11 bits (PixelsForPage). The boxes of `results` count pixels of the
/// whole frame, of which images may be a part (their data window). Every name and text of `results` is
/// escaped. Cost: a few times the pixels' bytes. Errors: std::logic_error for a null image.
std::string MakeCompareReport(const nlohmann::ordered_json& results, const std::vector<ReportImage>& images);

}  // namespace lacquer::cmd
