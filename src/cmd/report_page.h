// Reports: HTML pages that need no other file and no network, from templates in data/report.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "pbrt/image/image.h"

namespace lacquer::cmd {

/// One image of a page.
struct ReportImage {
    std::string file;              ///< its path as the results have it
    const Image* image = nullptr;  ///< RGB, or one channel (a map of errors); alive while the page is made
};

/// What a page is made of.
struct ReportPage {
    const char* page = nullptr;            ///< the template's name in data/report
    std::string title;                     ///< plain text
    std::span<const char* const> styles;   ///< names in data/report
    std::span<const char* const> scripts;  ///< the same, in the order in which they need each other
    const nlohmann::ordered_json* results = nullptr;  ///< embedded whole
    const std::vector<ReportImage>* images = nullptr;
};

/// The page's text (UTF-8): the template with its parts put in, each {{name}} one of title, style, results,
/// magma, images, notices, chart and script. Whatever text title, results and images have, it is escaped.
/// Pixels keep 11 bits (PixelsForPage). Cost: a few times the pixels' bytes. Errors: std::logic_error for a
/// null image.
std::string MakeReportPage(const ReportPage& parts);

}  // namespace lacquer::cmd
