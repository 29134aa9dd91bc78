// Small renders of a medium.
#pragma once

#include <string>
#include <vector>

#include "pbrt/image/image.h"
#include "pbrt/scattering/bulk_table.h"

namespace lacquer::cmd {

struct BulkThumbnail {
    std::string name;     ///< "wedge" or "ball"
    std::string caption;  ///< what is seen, with its size
    Image image;          ///< linear, white is 1
};

/// A wedge that is lit from behind, and a ball on a table. Their sizes follow from the medium: some transport
/// mean free paths at the wavelength in the middle, fewer where others are scattered too often. None for a
/// medium that does nothing. The same bits each time; seconds.
/// @param tablePath  of the file that holds `table`; @param resolution  pixels a side
/// Errors: those of reading it.
std::vector<BulkThumbnail> RenderBulkThumbnails(const std::string& tablePath, const BulkTable& table,
                                                int resolution);

}  // namespace lacquer::cmd
